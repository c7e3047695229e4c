"""Find the original files of measured sets in a folder, or download them; a file is accepted only if it is the one that was published.

A file is identified by its SHA-256, so it may come from any place: from a folder of the files alone, of a folder for each repository or of
a clone, or from any of several addresses.
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

PROBE_SECONDS = 5.0  # time in which an address has to answer
FETCH_SECONDS = 60.0  # longest pause in a download
MAX_BYTES = 100_000_000  # largest file


@dataclass(frozen=True)
class Original:
    """A published file.

    Attributes:
        set: Name of the measured set.
        mapping: Name of the mapping in ``configs/measured`` that imports it; campaigns of one arm in one format share it.
        file: Name of the file.
        sha256: Checksum of the file.
        repository: Repository that contains it, ``owner/name``.
        commit: Commit of the repository.
        path: Path of the file in the repository.
    """

    set: str
    mapping: str
    file: str
    sha256: str
    repository: str
    commit: str
    path: str

    def addresses(self, templates: Sequence[str]) -> list[str]:
        """Return the addresses of the file: the templates with ``{repository}``, ``{commit}`` and ``{path}`` filled in."""
        return [t.format(repository=self.repository, commit=self.commit, path=self.path) for t in templates]

    def find(self, folder: Path) -> Path | None:
        """Return the path of the file in a local folder, directly, in a folder of the repository's name, or as in a clone; None if it is missing."""
        repository = self.repository.rsplit("/", 1)[-1]
        for place in (self.file, f"{repository}/{self.file}", f"{repository}/{self.path}", self.path):
            if (folder / place).is_file():
                return folder / place
        return None


def read_originals(path: str | Path) -> dict[str, list[Original]]:
    """Return ``{set: its originals}`` from a CSV table with the attributes of ``Original`` as columns."""
    found: dict[str, list[Original]] = {}
    with open(path, encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            found.setdefault(row["set"], []).append(Original(**row))
    return found


def answers(address: str) -> bool:
    """Return whether a file can be downloaded from an address; the answer takes a few seconds even if names are not resolved."""
    found: list[bool] = []

    def ask() -> None:
        try:
            with urlopen(Request(address, method="HEAD"), timeout=PROBE_SECONDS):
                found.append(True)
        except HTTPError:
            found.append(False)  # a server answers, but does not have the file
        except (OSError, ValueError):
            pass

    thread = threading.Thread(target=ask, daemon=True)
    thread.start()
    thread.join(2 * PROBE_SECONDS)
    return any(found)


def get_originals(
    originals: Sequence[Original], folder: str, templates: Sequence[str], out_dir: str | Path
) -> None:
    """Write the originals of a set to a folder of their own, after comparing their checksums.

    Args:
        originals: The originals of the set.
        folder: Local folder that is searched first, or an empty text.
        templates: Addresses to try in turn, with ``{repository}``, ``{commit}`` and ``{path}``.
        out_dir: The folder to write, whole or not at all.

    Raises:
        InvalidInput: A file is not found, or is not the one that was published; every such file is named.
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
    """Write a file from the first address that has it; return a fault if none has it, else no fault."""
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
    """Return ``{name: SHA-256}`` of the files in a folder, without hidden files (such as Snakemake's time stamp)."""
    paths = sorted(path for path in Path(folder).iterdir() if path.is_file() and path.name[0] != ".")
    return {path.name: _sha256(path.read_bytes()) for path in paths}


def _sha256(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()
