"""What a fresh clone, and a user without the simulator, rely on: imports, versions, the lock, the set-up's refusal."""

import ast
import os
import re
import shutil
import subprocess
import sys
import tomllib
from importlib import metadata
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name
from ruamel.yaml import YAML

import scalar

ROOT = Path(__file__).resolve().parents[1]
PYPROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
LOCKS = {name: ROOT / "requirements" / f"{name}.txt" for name in ("lock", "bootstrap")}

BLOCK_PYBULLET = """
import importlib, sys
class Blocker:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in ("pybullet", "pybullet_data"):
            raise ImportError(f"{name} is blocked by the test")
sys.meta_path.insert(0, Blocker())
for module in sys.argv[1:]:
    importlib.import_module(module)
"""


def python_files(*folders: str) -> list[Path]:
    return sorted(path for folder in folders for path in (ROOT / folder).rglob("*.py"))


def in_simulation(path: Path) -> bool:
    return path.is_relative_to(ROOT / "scalar" / "simulation")


def imported_names(path: Path) -> set[str]:
    """Return the absolute dotted names that a file imports, anywhere in it: `from a import b` gives a and a.b."""
    names: set[str] = set()
    package = path.relative_to(ROOT).parent.parts
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = list(package[: len(package) - node.level + 1]) if node.level else []
            source = ".".join(base + ([node.module] if node.module else []))
            names.update([source, *(f"{source}.{alias.name}" for alias in node.names)])
    return names


def locked_requirements(lock: Path) -> list[tuple[Requirement, list[str]]]:
    """Return each requirement of a lock file with its hashes."""
    entries = []
    for line in lock.read_text(encoding="utf-8").replace("\\\n", " ").splitlines():
        line = line.partition("#")[0].strip()
        if line:
            requirement, *hashes = re.split(r"\s+--hash=", line)
            entries.append((Requirement(requirement), hashes))
    return entries


# --- no pybullet outside the simulator -----------------------------------------------------------------------------


def test_all_but_the_simulator_imports_without_pybullet() -> None:
    """Calibrating one's own data needs no pybullet: every module outside scalar.simulation imports without it."""
    modules = [
        ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")
        for path in python_files("scalar")
        if not in_simulation(path) and path.name != "__main__.py"
    ]
    assert "scalar" in modules
    run = subprocess.run(
        [sys.executable, "-c", BLOCK_PYBULLET, *modules], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert run.returncode == 0, run.stderr


def test_the_blocker_blocks() -> None:
    """The test above can fail: with the same hook, importing pybullet is an ImportError."""
    run = subprocess.run(
        [sys.executable, "-c", BLOCK_PYBULLET, "pybullet"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert run.returncode != 0
    assert "blocked by the test" in run.stderr


def test_only_the_simulator_names_pybullet() -> None:
    """No file outside scalar/simulation imports pybullet, not even inside a function. Tests may."""
    offenders = [
        str(path.relative_to(ROOT))
        for path in python_files("scalar", "workflow", "benchmarks")
        if not in_simulation(path) and any(name.partition(".")[0] == "pybullet" for name in imported_names(path))
    ]
    assert offenders == []


def test_the_simulator_shares_no_model_with_the_estimator() -> None:
    """No inverse crime: the simulator imports nothing that models residuals or fits them."""
    estimator = {
        "calibrate",
        "compression",
        "effects",
        "evaluate",
        "identifiability",
        "initial",
        "model",
        "parameters",
        "published",
        "residuals",
    }
    offenders = {
        f"{path.relative_to(ROOT)}: {name}"
        for path in python_files("scalar/simulation")
        for name in imported_names(path)
        if name.startswith("scalar.") and name.split(".")[1] in estimator
    }
    assert offenders == set()


# --- one version ---------------------------------------------------------------------------------------------------


def test_versions_agree() -> None:
    """scalar.__version__ is the one source; pyproject reads it, CITATION.cff and the newest CHANGELOG entry repeat it."""
    assert PYPROJECT["project"]["dynamic"] == ["version"]
    assert PYPROJECT["tool"]["hatch"]["version"]["path"] == "scalar/__init__.py"
    citation = YAML(typ="safe").load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert str(citation["version"]) == scalar.__version__
    headings = re.findall(r"^## \[(.+?)\]", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), re.MULTILINE)
    assert headings[0] in ("Unreleased", scalar.__version__)


def test_installed_metadata_agrees() -> None:
    """The installed distribution says the same version, and `scalar` is scalar.cli:main."""
    try:
        distribution = metadata.distribution(PYPROJECT["project"]["name"])
    except metadata.PackageNotFoundError:
        pytest.skip("scalar is not installed here; `make env` installs it")
    assert distribution.version == scalar.__version__
    scripts = {entry.name: entry.value for entry in distribution.entry_points if entry.group == "console_scripts"}
    assert scripts == {"scalar": "scalar.cli:main"}


# --- the lock ------------------------------------------------------------------------------------------------------


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
    assert re.search(r"^\s*(-i|-f|-e|--(extra-)?index-url|--find-links|--trusted-host)\b", text, re.MULTILINE) is None
    assert not any(requirement.url for requirement, _ in locked_requirements(LOCKS[name]))


def test_lock_covers_pyproject() -> None:
    """Whatever pyproject asks for, extras and build backend included, is locked at a version that satisfies it."""
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
        assert requirement.specifier.contains(version), f"the lock has {entry}, pyproject wants {requirement}: make lock"


def test_bootstrap_agrees_with_lock() -> None:
    """What is installed first is part of the lock, at the same version: the second install changes nothing of it."""
    lock, bootstrap = ({str(entry) for entry, _ in locked_requirements(LOCKS[name])} for name in ("lock", "bootstrap"))
    assert bootstrap <= lock


def test_pybullet_is_an_extra() -> None:
    """The core dependencies hold neither the simulator nor the workflow nor the developer's tools."""
    core = {canonicalize_name(Requirement(text).name) for text in PYPROJECT["project"]["dependencies"]}
    extras = PYPROJECT["project"]["optional-dependencies"]
    assert set(extras) == {"simulation", "workflow", "dev"}
    for group in extras.values():
        assert core.isdisjoint(canonicalize_name(Requirement(text).name) for text in group)


# --- the set-up ----------------------------------------------------------------------------------------------------


@pytest.fixture
def bare_clone(tmp_path: Path) -> Path:
    """Return a folder, with a blank in its path, that holds what `make env` reads."""
    clone = tmp_path / "a clone"
    for name in ("Makefile", "pyproject.toml", "requirements", "scalar/__init__.py"):
        source, target = ROOT / name, clone / name
        target.parent.mkdir(parents=True, exist_ok=True)
        (shutil.copytree if source.is_dir() else shutil.copy)(source, target)
    return clone


def fake_python(folder: Path, version: str) -> Path:
    """Write a `python3` that has the wrong version: it answers a program that prints, and fails one that checks."""
    folder.mkdir()
    executable = folder / "python3"
    executable.write_text(
        f'#!/bin/sh\ncase "$2" in *venv*) exit 1;; *) echo "python3 is {version}";; esac\n', encoding="utf-8"
    )
    executable.chmod(0o755)
    return executable


def make(clone: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    environment = {name: value for name, value in os.environ.items() if not name.startswith("MAKE")}
    return subprocess.run(
        ["make", "--no-print-directory", *arguments],
        cwd=clone,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.parametrize(("version", "said"), [("3.12.1", "python3 is 3.12.1"), (None, "no Python")])
def test_wrong_python_is_one_clear_line(bare_clone: Path, tmp_path: Path, version: str | None, said: str) -> None:
    """Without Python 3.11 `make` fails before it touches anything, in one line that says what is needed and found."""
    python = fake_python(tmp_path / "bin", version) if version else tmp_path / "bin" / "python3"
    run = make(bare_clone, "env", f"PYTHON={python}")
    assert run.returncode != 0
    (line,) = (run.stdout + run.stderr).splitlines()
    assert "needs Python 3.11" in line
    assert said in line
    assert not (bare_clone / ".venv").exists()


def test_half_built_environment_is_not_taken_for_complete(bare_clone: Path) -> None:
    """An environment without its stamp is built again; with it, `make env` has nothing to do."""
    (bare_clone / ".venv" / "bin").mkdir(parents=True)
    assert make(bare_clone, "--question", "env").returncode == 1
    for stamp in (".locked", ".installed"):
        (bare_clone / ".venv" / stamp).touch()
    assert make(bare_clone, "--question", "env").returncode == 0
