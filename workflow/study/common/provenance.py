"""Which code made a table, and by which design: version, commit where there is one, and checksums of the sources and of the design."""

from __future__ import annotations

import hashlib
import json
import subprocess
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import scalar
import study

_PACKAGES = tuple(Path(package.__path__[0]) for package in (scalar, study))
_SOURCES = ("*.py", "*.json", "*.jinja")


def code_version() -> dict[str, str | None]:
    """Return ``{"version", "commit", "sources_sha256"}`` of the code that runs.

    The commit is None outside a repository, and ends in ``-modified`` if sources differ from it. The checksum is over the names and contents of all
    sources of both packages, so that a checkout and a copy of it have the same checksum.
    """
    checksum = sources_checksum(*_PACKAGES)
    return {"version": scalar.__version__, "commit": _commit(), "sources_sha256": checksum}


def design_identity(design: Mapping[str, Any]) -> dict[str, Any]:
    """Return ``{"seed", "sealed_after", "sha256"}`` of the content of a design of trials; ``sealed_after`` is None without a freeze of the code."""
    checksum = hashlib.sha256(json.dumps(design, sort_keys=True).encode()).hexdigest()
    return {"seed": design["seed"], "sealed_after": design.get("sealed_after"), "sha256": checksum}


def sources_checksum(*packages: Path) -> str:
    """Return the checksum of the sources of packages, in hexadecimal digits."""
    digest = hashlib.sha256()
    for package in packages:
        for path in sorted({path for name in _SOURCES for path in package.rglob(name)}):
            place = path.relative_to(package.parent).as_posix()
            digest.update(place.encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()


def _commit() -> str | None:
    def git(*arguments: str) -> str:
        command = ["git", "-C", str(_PACKAGES[0]), *arguments]
        return subprocess.run(command, capture_output=True, text=True, check=True, timeout=20).stdout.strip()

    try:
        changed = git("status", "--porcelain", "--", *map(str, _PACKAGES))
        return git("rev-parse", "HEAD") + ("-modified" if changed else "")
    except (OSError, subprocess.SubprocessError):
        return None
