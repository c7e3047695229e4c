"""The original files of measured sets: found in a folder, or fetched, and taken only if they are what was published.

A file is known by its SHA-256. Where it came from then does not matter: a folder laid out flat, by repository or
as a clone, or any of several addresses.
"""

from __future__ import annotations

import csv
import hashlib
import shutil
import threading
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from urllib.error import HTTPError
from urllib.request import Request, urlopen

from scalar.data.io.atomic import atomic_directory
from scalar.errors import Fault, InvalidInput

PROBE_SECONDS = 5.0  # for one address to answer at all
FETCH_SECONDS = 60.0  # without a byte of a file
MAX_BYTES = 100_000_000


@dataclass(frozen=True)
class Original:
    """A published file: its set, name and checksum, and where in which repository it stands."""

    set: str
    file: str
    sha256: str
    repository: str
    commit: str
    path: str

    def addresses(self, templates: Sequence[str]) -> list[str]:
        """Return the addresses of the file: ``{repository}``, ``{commit}`` and ``{path}`` filled in."""
        return [t.format(repository=self.repository, commit=self.commit, path=self.path) for t in templates]

    def find(self, folder: Path) -> Path | None:
        """Return the file in a local folder, flat, by repository or as a clone; None if it is not there."""
        repository = self.repository.rsplit("/", 1)[-1]
        for place in (self.file, f"{repository}/{self.file}", f"{repository}/{self.path}", self.path):
            if (folder / place).is_file():
                return folder / place
        return None


def read_originals(path: str | Path) -> dict[str, list[Original]]:
    """Return the originals of each set, as a table lists them."""
    found: dict[str, list[Original]] = {}
    with open(path, encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            found.setdefault(row["set"], []).append(Original(**row))
    return found


def answers(address: str) -> bool:
    """Return whether anything is behind an address; in a few seconds, even where names are not resolved."""
    heard: list[bool] = []

    def ask() -> None:
        try:
            with urlopen(Request(address, method="HEAD"), timeout=PROBE_SECONDS):
                heard.append(True)
        except HTTPError:
            heard.append(False)  # somebody is there, and has not this file
        except (OSError, ValueError):
            pass

    thread = threading.Thread(target=ask, daemon=True)
    thread.start()
    thread.join(2 * PROBE_SECONDS)
    return any(heard)


def get_originals(
    originals: Sequence[Original], folder: str, templates: Sequence[str], out_dir: str | Path
) -> None:
    """Write the originals of a set to a folder of their own, each with the checksum that it should have.

    Args:
        originals: of the set.
        folder: a local folder to look in first, or empty.
        templates: addresses to try in turn, with ``{repository}``, ``{commit}`` and ``{path}``.
        out_dir: appears whole or not at all.

    Raises:
        InvalidInput: a file is nowhere, or not what was published; every one that is so is named.
    """
    faults: list[Fault] = []
    with atomic_directory(out_dir) as temporary:
        for original in originals:
            local = original.find(Path(folder)) if folder else None
            if local is None:
                faults += _fetch(original, original.addresses(templates), temporary / original.file)
            elif (found := _sha256(local.read_bytes())) != original.sha256:
                message = f"not the file that was published (SHA-256 {found}, expected {original.sha256})"
                faults.append(Fault(str(local), f"{message}; get it anew"))
            else:
                shutil.copyfile(local, temporary / original.file)
        if faults:
            raise InvalidInput(faults)


def _fetch(original: Original, addresses: Sequence[str], path: Path) -> list[Fault]:
    """Fetch a file from the first address that has it; return a fault if none does."""
    reasons = []
    for address in addresses:
        try:
            with urlopen(address, timeout=FETCH_SECONDS) as answer:
                content = answer.read(MAX_BYTES + 1)
        except (OSError, ValueError) as error:
            reasons.append(f"{address}: {getattr(error, 'reason', None) or error}")
            continue
        if _sha256(content) == original.sha256:
            path.write_bytes(content)
            return []
        reasons.append(f"{address}: not the file that was published (SHA-256 {_sha256(content)})")
    message = (
        f"cannot be fetched ({'; '.join(reasons)}); put it in a folder, and name that as measured.folder"
    )
    return [Fault(original.file, message)]


def checksums(folder: str | Path) -> dict[str, str]:
    """Return the SHA-256 of every file in a folder, by name; hidden files (Snakemake's time stamp) aside."""
    paths = sorted(path for path in Path(folder).iterdir() if path.is_file() and path.name[0] != ".")
    return {path.name: _sha256(path.read_bytes()) for path in paths}


def _sha256(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()
