"""Set the version everywhere it stands, and close the open section of the changelog: `make release VERSION=0.3.0`.

The version stands in scalar/__init__.py (which pyproject.toml reads) and CITATION.cff; CHANGELOG.md has a heading for each release. Commit and
tag afterwards.
"""

from __future__ import annotations

import re
import sys
from datetime import date
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
VERSION = re.compile(r"(\d+)\.(\d+)\.(\d+)")


def release(root: Path, version: str, day: date) -> None:
    """Write a version into the files of a checkout.

    Raises:
        ValueError: It is no version, none later than the present one, or nothing is listed as changed.
    """
    package, citation, changelog = (
        root / name for name in ("scalar/__init__.py", "CITATION.cff", "CHANGELOG.md")
    )
    texts = {path: path.read_text(encoding="utf-8") for path in (package, citation, changelog)}
    wanted = VERSION.fullmatch(version)
    if wanted is None:
        raise ValueError(f"'{version}' is no version; write three numbers, as in 0.2.0")
    found = re.search(r'(?m)^__version__ = "(.+)"$', texts[package])
    present = VERSION.fullmatch(found[1]) if found else None
    if present is None:
        raise ValueError(f'{package}: no line __version__ = "..." with three numbers')
    if tuple(map(int, wanted.groups())) <= tuple(map(int, present.groups())):
        raise ValueError(f"{version} is not later than {present[0]}")
    parts = re.split(r"(?m)^(## \[.+)$\n", texts[changelog])
    if len(parts) < 3 or parts[1] != "## [Unreleased]" or not parts[2].strip():
        raise ValueError(f"{changelog}: the section [Unreleased] is missing or empty")
    parts[1] = f"## [Unreleased]\n\n## [{version}] - {day.isoformat()}"
    texts[changelog] = parts[0] + "".join(
        f"{head}\n{body}" for head, body in zip(parts[1::2], parts[2::2], strict=True)
    )
    texts[package] = texts[package].replace(present[0], version, 1)
    cited = re.sub(r"(?m)^date-released: .*\n", "", texts[citation])
    texts[citation] = re.sub(
        r"(?m)^version: .*$", f"version: {version}\ndate-released: {day.isoformat()}", cited
    )
    for path, text in texts.items():
        path.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    try:
        release(ROOT, sys.argv[1] if len(sys.argv) > 1 else "", date.today())
    except ValueError as error:
        sys.exit(f"release: {error}")
    print(f"version {sys.argv[1]}: commit, and tag v{sys.argv[1]}")
