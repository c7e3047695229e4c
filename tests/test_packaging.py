"""What a user without the simulator relies on: no pybullet, one version, package data, extras."""

import ast
import re
import subprocess
import sys
import tomllib
import zipfile
from importlib import metadata
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name
from ruamel.yaml import YAML

import scalar

ROOT = Path(__file__).resolve().parents[1]
PYPROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))

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
    """Return the Python files below folders of the repository."""
    return sorted(path for folder in folders for path in (ROOT / folder).rglob("*.py"))


def in_simulation(path: Path) -> bool:
    """Return whether a file belongs to the simulator."""
    return path.is_relative_to(ROOT / "scalar" / "simulation")


def imported_names(path: Path) -> set[str]:
    """Return the absolute dotted names that a file imports; `from a import b` gives a and a.b."""
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


def run_python(*arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, *arguments], cwd=ROOT, capture_output=True, text=True, check=False)


def test_all_but_the_simulator_imports_without_pybullet() -> None:
    """Calibrating one's own data needs no pybullet: all modules outside scalar.simulation import without."""
    modules = [
        ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")
        for path in python_files("scalar")
        if not in_simulation(path) and path.name != "__main__.py"
    ]
    assert "scalar" in modules
    run = run_python("-c", BLOCK_PYBULLET, *modules)
    assert run.returncode == 0, run.stderr


def test_the_blocker_blocks() -> None:
    """The test above can fail: with the same hook, importing pybullet is an ImportError."""
    run = run_python("-c", BLOCK_PYBULLET, "pybullet")
    assert run.returncode != 0
    assert "blocked by the test" in run.stderr


def test_only_the_simulator_names_pybullet() -> None:
    """No file outside scalar/simulation imports pybullet, not even inside a function. Tests may, and so may the benchmark against its bare call."""
    measured_against = ROOT / "benchmarks" / "simulation.py"
    offenders = [
        str(path.relative_to(ROOT))
        for path in python_files("scalar", "workflow", "benchmarks")
        if not (in_simulation(path) or path == measured_against)
        and any(name.partition(".")[0] == "pybullet" for name in imported_names(path))
    ]
    assert offenders == []


def test_versions_agree() -> None:
    """pyproject, CITATION.cff and CHANGELOG.md have the version of scalar.__version__."""
    assert PYPROJECT["project"]["dynamic"] == ["version"]
    assert PYPROJECT["tool"]["hatch"]["version"]["path"] == "scalar/__init__.py"
    citation = YAML(typ="safe").load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert str(citation["version"]) == scalar.__version__
    headings = re.findall(r"^## \[(.+?)\]", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), re.MULTILINE)
    assert headings[0] in ("Unreleased", scalar.__version__)
    released = [heading for heading in headings if heading != "Unreleased"]
    assert not released or released[0] == scalar.__version__


def test_installed_metadata_agrees() -> None:
    """The installed distribution says the same version, and `scalar` is scalar.cli:main."""
    try:
        distribution = metadata.distribution(PYPROJECT["project"]["name"])
    except metadata.PackageNotFoundError:
        pytest.skip("scalar is not installed here; `make env` installs it")
    assert distribution.version == scalar.__version__
    scripts = {
        entry.name: entry.value for entry in distribution.entry_points if entry.group == "console_scripts"
    }
    assert scripts == {"scalar": "scalar.cli:main"}


def test_pybullet_is_an_extra() -> None:
    """The core dependencies hold neither the simulator nor the workflow nor the developer's tools."""
    core = {canonicalize_name(Requirement(text).name) for text in PYPROJECT["project"]["dependencies"]}
    extras = PYPROJECT["project"]["optional-dependencies"]
    assert set(extras) == {"bags", "simulation", "slurm", "workflow", "docs", "dev"}
    for group in extras.values():
        assert core.isdisjoint(canonicalize_name(Requirement(text).name) for text in group)


@pytest.mark.slow
def test_wheel_holds_schemas_and_templates(tmp_path: Path) -> None:
    """A wheel holds every module and data file of the package, and nothing else of the repository."""
    pytest.importorskip("hatchling", reason="the build backend is not installed here; `make env` installs it")
    run = run_python("-m", "hatchling", "build", "-t", "wheel", "-d", str(tmp_path))
    assert run.returncode == 0, run.stderr
    (wheel,) = tmp_path.glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        packed = {name for name in archive.namelist() if ".dist-info/" not in name}
    tree = {path.relative_to(ROOT).as_posix() for path in (ROOT / "scalar").rglob("*") if path.is_file()}
    assert packed == {name for name in tree if "__pycache__" not in name}
