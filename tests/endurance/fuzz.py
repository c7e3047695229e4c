"""Damage good files at random, and read them.

    python -m tests.endurance.fuzz --inputs 100000 --finds finds

Each input is read, or refused with sentences that can be printed. Everything else is a find: another exception, more than 20 s, half a gigabyte, and
a file whose content is that of the good one and which is read otherwise. Finds are kept as files; each becomes a test.
"""

from __future__ import annotations

import argparse
import random
import resource
import shutil
import signal
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from scalar.errors import ScalarError
from tests.endurance.mutations import mutated
from tests.endurance.readers import READERS, Reader, answer

PATIENCE = 20  # s
MEMORY = 500_000  # kB by which the process may grow for one input


class TooLong(BaseException):
    """Reading one input took too long."""


@contextmanager
def patience(seconds: int) -> Iterator[None]:
    """Raise TooLong where the block takes longer."""

    def stop(*_: object) -> None:
        raise TooLong

    before = signal.signal(signal.SIGALRM, stop)
    signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


class Fuzzed:
    """Good files of one reader, and what became of damaged copies.

    Attributes:
        counts: Of inputs that were read, refused, and finds.
        finds: A line for each kind of find.
    """

    def __init__(self, reader: Reader, folder: Path) -> None:
        self.reader, self.folder = reader, folder
        self.good = folder / "good"
        self.good.mkdir(parents=True)
        reader.make(self.good)
        self.expected = answer(reader.read(self.good))
        self.files = sorted(p for pattern in reader.damaged for p in self.good.rglob(pattern) if p.is_file())
        self.counts: Counter[str] = Counter()
        self.finds: dict[str, str] = {}

    def one(self, rng: random.Random) -> str | None:
        """Read one damaged copy; return the kind of find, or None."""
        file = rng.choice(self.files)
        raw = mutated(file.read_bytes(), rng)
        copy = self.folder / "bad"
        if not copy.exists():
            shutil.copytree(self.good, copy)
        path = copy / file.relative_to(self.good)
        path.write_bytes(raw)
        try:
            return self._judged(copy, path, file)
        finally:
            shutil.copyfile(file, path)

    def _judged(self, copy: Path, path: Path, good: Path) -> str | None:
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        try:
            with patience(PATIENCE):
                found = answer(self.reader.read(copy))
        except ScalarError as error:
            self.counts["refused"] += 1
            bad = not all(line.isprintable() for line in str(error).splitlines())
            return self._find("a message that cannot be printed", path) if bad else None
        except TooLong:
            return self._find(f"longer than {PATIENCE} s", path)
        except Exception as error:
            where = traceback.extract_tb(error.__traceback__)[-1]
            what = f"{type(error).__name__} in {Path(where.filename).name}:{where.lineno}: {str(error)[:120]}"
            return self._find(what, path)
        self.counts["read"] += 1
        grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
        if grown > MEMORY:
            return self._find("half a gigabyte", path)
        if found != self.expected and self._same_content(path, good):
            return self._find("the same content, read otherwise", path)
        return None

    def _same_content(self, path: Path, good: Path) -> bool:
        if self.reader.content is None:
            return False
        both: list[Any] = [self.reader.content(p) for p in (path, good)]
        return repr(both[0]) == repr(both[1])

    def _find(self, what: str, path: Path) -> str:
        self.counts["finds"] += 1
        if what not in self.finds:
            kept = self.folder / "finds" / f"{len(self.finds)}-{path.name}"
            kept.parent.mkdir(exist_ok=True)
            shutil.copyfile(path, kept)
            self.finds[what] = kept.name
        return what


def main() -> None:
    """Run from the command line; exit status 1 if there are finds."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--inputs", type=int, default=20_000, help="of all readers together")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", nargs="*", choices=READERS, default=list(READERS))
    parser.add_argument("--seconds", type=float, default=1e9, help="at most, for each reader")
    parser.add_argument("--finds", type=Path, help="folder to keep finds in")
    wanted = parser.parse_args()
    warnings.simplefilter("error")
    with tempfile.TemporaryDirectory() as temporary:
        finds = 0
        for name in wanted.only:
            fuzzed = Fuzzed(READERS[name], Path(temporary) / name.replace(" ", "-"))
            rng = random.Random(f"{wanted.seed} {name}")
            started = time.monotonic()
            for _ in range(wanted.inputs // len(wanted.only)):
                fuzzed.one(rng)
                if time.monotonic() - started > wanted.seconds:
                    break
            counts = fuzzed.counts
            print(
                f"{name:24s} {sum(counts.values()):7d} inputs: {counts['read']} read, {counts['refused']} refused, "
                f"{counts['finds']} finds of {len(fuzzed.finds)} kinds, {time.monotonic() - started:.0f} s",
                flush=True,
            )
            for what, kept in fuzzed.finds.items():
                print(f"    {what} ({kept})", flush=True)
            if wanted.finds and fuzzed.finds:
                shutil.copytree(
                    fuzzed.folder / "finds", wanted.finds / name.replace(" ", "-"), dirs_exist_ok=True
                )
            finds += len(fuzzed.finds)
    sys.exit(1 if finds else 0)


if __name__ == "__main__":
    main()
