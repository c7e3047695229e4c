"""Damage good files at random, and read them.

    python -m tests.endurance.fuzz --inputs 100000 --finds finds --table fuzz.csv

Each input is read, or refused with sentences that can be printed. Everything else is a find: another exception, more than 20 s of processor time,
half a gigabyte, and a file whose content is that of the good one and which is read otherwise. Finds are kept as files; each becomes a test. The
readers take turns, so that a run which is stopped has tried all of them alike.
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
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from unittest import mock

import pandas as pd
from ruamel.yaml import YAML

from scalar.errors import ScalarError
from tests.endurance.readers import READERS, Reader, answer

PATIENCE = 20  # s of processor time
LONGEST = 1200  # s, waiting included: a reader that only waits uses no processor
ROUND = 100  # inputs of a reader before it is the next one's turn
MEMORY = 500_000  # kB by which the process may grow for one input


class TooLong(BaseException):
    """Reading one input took too long."""


@contextmanager
def patience(seconds: int) -> Iterator[None]:
    """Raise TooLong where the block takes more processor time, on however busy a machine, or does nothing but wait."""

    def stop(*_: object) -> None:
        raise TooLong

    before = {number: signal.signal(number, stop) for number in (signal.SIGPROF, signal.SIGALRM)}
    signal.setitimer(signal.ITIMER_PROF, seconds)
    signal.alarm(LONGEST)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.alarm(0)
        for number, handler in before.items():
            signal.signal(number, handler)


@contextmanager
def parsed_once(texts: Collection[str]) -> Iterator[None]:
    """Parse each of some texts, those of good files, only once within the block, since parsing YAML takes most of the time."""
    known: dict[str, list[Any]] = {}

    class Parser(YAML):
        def parse(self, stream: Any) -> Any:
            text = stream.getvalue()
            if text not in texts:
                return super().parse(stream)
            if text not in known:
                known[text] = list(super().parse(stream))
            return iter(known[text])

    with mock.patch("scalar.data.io.plain_yaml.YAML", Parser):
        yield


class Fuzzed:
    """Good files of one reader, and the counts and finds of damaged copies.

    Attributes:
        counts: Of inputs that were read, refused, and finds.
        finds: For each kind of find, the name of the file that is kept.
        slowest: Processor time of the input that took longest [s].
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
        self.slowest = 0.0
        self._texts = {
            path.read_bytes().decode("utf-8-sig")
            for path in self.good.rglob("*.yaml")
        }  # fmt: skip

    def one(self, rng: random.Random) -> str | None:
        """Read one damaged copy; return the kind of find, or None."""
        file = rng.choice(self.files)
        raw = self.reader.damage(file.read_bytes(), rng)
        copy = self.folder / "bad"
        if not copy.exists():
            shutil.copytree(self.good, copy)
        path = copy / file.relative_to(self.good)
        path.write_bytes(raw)
        started = time.process_time()
        try:
            with parsed_once(self._texts):
                return self._judged(copy, path, file)
        finally:
            self.slowest = max(self.slowest, time.process_time() - started)
            shutil.copyfile(file, path)

    def row(self) -> dict[str, Any]:
        """Return a row of the table of a long run."""
        counts = {what: self.counts[what] for what in ("read", "refused", "finds")}
        return {
            "reader": self.reader.name,
            "inputs": sum(counts.values()),
            **counts,
            "kinds_of_finds": len(self.finds),
            "slowest_s": round(self.slowest, 2),
        }

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
            return self._find(f"longer than {PATIENCE} s of processor time, or {LONGEST} s", path)
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
        return f"{what}; kept as {self.folder / 'finds' / self.finds[what]}"


def main() -> None:
    """Run from the command line; exit status 1 if there are finds."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--inputs", type=int, default=20_000, help="of all readers together")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", nargs="*", choices=READERS, default=list(READERS))
    parser.add_argument("--finds", type=Path, help="folder to keep finds in")
    parser.add_argument(
        "--table", type=Path, help="CSV file with a row for each reader, written after every round"
    )
    wanted = parser.parse_args()
    warnings.simplefilter("error")
    with tempfile.TemporaryDirectory() as temporary:
        everything = {
            name: (Fuzzed(READERS[name], Path(temporary) / name.replace(" ", "-")), random.Random(f"{wanted.seed} {name}"))
            for name in wanted.only
        }  # fmt: skip
        left = -(-wanted.inputs // len(wanted.only))
        while left > 0:
            for name, (fuzzed, rng) in everything.items():
                known = set(fuzzed.finds)
                for _ in range(min(ROUND, left)):
                    fuzzed.one(rng)
                for what in fuzzed.finds.keys() - known:
                    print(f"{name}: {what} ({fuzzed.finds[what]})", flush=True)
                    if wanted.finds:
                        kept = wanted.finds / name.replace(" ", "-")
                        kept.mkdir(parents=True, exist_ok=True)
                        shutil.copy(fuzzed.folder / "finds" / fuzzed.finds[what], kept)
            left -= ROUND
            rows = pd.DataFrame([fuzzed.row() for fuzzed, _ in everything.values()])
            if wanted.table:
                rows.to_csv(wanted.table, index=False)
    print(rows.to_string(index=False))
    sys.exit(1 if rows["finds"].any() else 0)


if __name__ == "__main__":
    main()
