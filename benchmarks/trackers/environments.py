"""Environments of the packages, one each, because what they need contradicts what the others need: ``python -m benchmarks.trackers.environments``.

Each is made from ``requirements/NAME.txt``, which pins versions and hashes. A package that cannot be installed leaves a file with the reason,
and the benchmark says it in its place.
"""

from __future__ import annotations

import hashlib
import re
import shutil
import subprocess
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

FOLDER = Path(__file__).parents[2] / ".bench"
REQUIREMENTS = Path(__file__).parent / "requirements"
PACKAGES = ("pybotics", "robotkinecal", "figaroh")
TIME_LIMIT = 1200.0  # s, for one environment
STAMP, REASON = ".installed", ".reason"


@dataclass(frozen=True)
class Missing:
    """A package that cannot be run, and why."""

    reason: str


def interpreter(package: str, folder: Path = FOLDER) -> Path | Missing:
    """Return the Python of a package's environment, or why there is none."""
    home, reason = folder / package, folder / f"{package}{REASON}"
    wanted = _requirements(package)
    if (home / STAMP).exists() and (home / STAMP).read_text(encoding="utf-8") == _digest(wanted):
        return home / "bin" / "python"
    if reason.exists():
        return Missing(reason.read_text(encoding="utf-8").strip())
    return Missing(f"{pinned(package)} is not installed: make bench-trackers installs it")


def pinned(package: str) -> str:
    """Return the package with the version that its requirements pin, as ``name==version``."""
    text = _requirements(package).read_text(encoding="utf-8")
    found = re.search(rf"^{re.escape(package)}==\S+", text, re.MULTILINE)
    assert found, f"{package} does not pin itself"
    return found[0]


def build(package: str, folder: Path = FOLDER, run: Callable[[Sequence[str]], None] | None = None) -> None:
    """Make the environment of a package, if it is not there yet; write the reason if it cannot be made.

    Args:
        package: One of ``PACKAGES``.
        folder: Of all environments.
        run: Runs a command; raises ``CommandFailed`` if it fails.
    """
    if not isinstance(interpreter(package, folder), Missing):
        return
    run = _run if run is None else run
    home, reason, wanted = folder / package, folder / f"{package}{REASON}", _requirements(package)
    shutil.rmtree(home, ignore_errors=True)
    reason.unlink(missing_ok=True)
    folder.mkdir(parents=True, exist_ok=True)
    try:
        run([sys.executable, "-m", "venv", str(home)])
        python = str(home / "bin" / "python")
        choice = ["--quiet", "--require-hashes", "--no-deps", "--only-binary", ":all:", "-r", str(wanted)]
        run([python, "-m", "pip", "install", "--disable-pip-version-check", *choice])
    except CommandFailed as failure:
        shutil.rmtree(home, ignore_errors=True)
        reason.write_text(f"{pinned(package)} could not be installed: {failure}\n", encoding="utf-8")
    else:
        (home / STAMP).write_text(_digest(wanted), encoding="utf-8")


class CommandFailed(Exception):
    """A command that failed, with the last line that it wrote."""


def last_line(text: str) -> str:
    """Return the last line of a program's messages that says something, without addresses."""
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    return re.sub(r"\S+://\S+", "...", lines[-1]) if lines else "it said nothing"


def _run(command: Sequence[str]) -> None:
    try:
        ended = subprocess.run(command, capture_output=True, text=True, check=False, timeout=TIME_LIMIT)
    except subprocess.TimeoutExpired:
        raise CommandFailed(f"not done after {TIME_LIMIT:.0f} s") from None
    if ended.returncode:
        raise CommandFailed(last_line(ended.stderr or ended.stdout))


def _requirements(package: str) -> Path:
    return REQUIREMENTS / f"{package}.txt"


def _digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def main() -> None:
    """Make all environments, one after the other, and print which there are."""
    for package in PACKAGES:
        print(f"{pinned(package)}: ", end="", flush=True)
        build(package)
        found = interpreter(package)
        print(found.reason if isinstance(found, Missing) else "installed")


if __name__ == "__main__":
    main()
