"""Which code made a table: version, commit where there is one, and a checksum of the package's own sources."""

from __future__ import annotations

import hashlib
import subprocess
from pathlib import Path

import scalar

_PACKAGE = Path(scalar.__file__).parent
_SOURCES = ("*.py", "*.json", "*.jinja")


def code_version() -> dict[str, str | None]:
    """Return ``{"version", "commit", "sources_sha256"}``; the commit is None outside a repository, or ``..-modified``.

    The checksum is over the names and contents of all sources in the package, so that it says the same of a
    checkout and of a copy.
    """
    return {"version": scalar.__version__, "commit": _commit(), "sources_sha256": sources_checksum(_PACKAGE)}


def sources_checksum(package: Path) -> str:
    """Return the checksum of a package's sources, in hexadecimal digits."""
    digest = hashlib.sha256()
    files = sorted(path.relative_to(package).as_posix() for name in _SOURCES for path in package.rglob(name))
    for name in files:
        digest.update(name.encode() + b"\0" + (package / name).read_bytes() + b"\0")
    return digest.hexdigest()


def _commit() -> str | None:
    def git(*arguments: str) -> str:
        command = ["git", "-C", str(_PACKAGE), *arguments]
        return subprocess.run(command, capture_output=True, text=True, check=True, timeout=20).stdout.strip()

    try:
        changed = git("status", "--porcelain", "--", str(_PACKAGE))
        return git("rev-parse", "HEAD") + ("-modified" if changed else "")
    except (OSError, subprocess.SubprocessError):
        return None
