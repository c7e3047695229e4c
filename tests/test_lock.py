"""The lock: exact, hashed, without any address, and enough for everything that pyproject.toml asks for."""

import re
import tomllib
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).resolve().parents[1]
PYPROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
LOCKS = {name: ROOT / "requirements" / f"{name}.txt" for name in ("lock", "bootstrap")}


def locked_requirements(lock: Path) -> list[tuple[Requirement, list[str]]]:
    """Return each requirement of a lock file with its hashes."""
    entries = []
    for line in lock.read_text(encoding="utf-8").replace("\\\n", " ").splitlines():
        line = line.partition("#")[0].strip()
        if line:
            requirement, *hashes = re.split(r"\s+--hash=", line)
            entries.append((Requirement(requirement), hashes))
    return entries


@pytest.mark.parametrize("name", LOCKS)
def test_lock_is_pinned_and_hashed(name: str) -> None:
    """Each requirement of a lock has one exact version and at least one sha256."""
    entries = locked_requirements(LOCKS[name])
    assert entries
    for requirement, hashes in entries:
        assert [specifier.operator for specifier in requirement.specifier] == ["=="], requirement
        assert hashes, requirement
        assert all(re.fullmatch(r"sha256:[0-9a-f]{64}", value) for value in hashes), requirement


@pytest.mark.parametrize("name", LOCKS)
def test_lock_names_no_address(name: str) -> None:
    """A lock works with any index: it holds no URL, no host, no path and no index option."""
    text = LOCKS[name].read_text(encoding="utf-8")
    assert "://" not in text
    assert re.search(r"\b[\w-]+\.(org|com|net|io)\b", text) is None
    assert (
        re.search(r"^\s*(-i|-f|-e|--(extra-)?index-url|--find-links|--trusted-host)\b", text, re.MULTILINE)
        is None
    )
    assert not any(requirement.url for requirement, _ in locked_requirements(LOCKS[name]))


def test_lock_covers_pyproject() -> None:
    """All that pyproject asks for, extras and build backend included, is locked at a fitting version."""
    project = PYPROJECT["project"]
    wanted = [
        Requirement(text)
        for group in (
            project["dependencies"],
            *project["optional-dependencies"].values(),
            PYPROJECT["build-system"]["requires"],
        )
        for text in group
    ]
    locked = {canonicalize_name(entry.name): entry for entry, _ in locked_requirements(LOCKS["lock"])}
    for requirement in wanted:
        entry = locked.get(canonicalize_name(requirement.name))
        assert entry is not None, f"{requirement} is not in the lock: make lock"
        (version,) = (specifier.version for specifier in entry.specifier)
        assert requirement.specifier.contains(version), (
            f"the lock has {entry}, pyproject wants {requirement}: make lock"
        )


def test_bootstrap_agrees_with_lock() -> None:
    """What is installed first is part of the lock, at the same version: the second install keeps it."""
    lock, bootstrap = (
        {str(entry) for entry, _ in locked_requirements(LOCKS[name])} for name in ("lock", "bootstrap")
    )
    assert bootstrap <= lock
