"""The library: a dozen names that cost nothing to import, each with an example that runs."""

import ast
import doctest
import re
import subprocess
import sys
import tomllib
from dataclasses import replace
from pathlib import Path

import pytest

import scalar
from tests.cli.test_start_up import SLOW
from tests.random_scene import make_scene

ROOT = Path(__file__).parents[1]
WITH_EXAMPLE = ("Calibration", "Dataset", "Robot", "calibrate", "diagnose", "read_dataset", "read_robot")


def test_importing_it_imports_no_library() -> None:
    """``import scalar`` and a look at its names import none of the slow libraries."""
    program = f"import scalar, sys; dir(scalar); print({{*sys.modules}} & {{*{SLOW!r}}} or 'none')"
    run = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "none"


def test_its_names_are_those_of_the_stub() -> None:
    """Every name of the stub, which a type checker sees, can be imported and has a docstring."""
    stub = ast.parse((ROOT / "scalar" / "__init__.pyi").read_text(encoding="utf-8"))
    names = {alias.name for node in stub.body if isinstance(node, ast.ImportFrom) for alias in node.names}
    assert names == set(scalar.__all__)
    for name in names:
        assert getattr(scalar, name).__doc__, name


@pytest.fixture
def my_cell(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a folder to work in, with the simulated dataset of the examples: joint 4 errs by one part in a thousand."""
    scene = make_scene(kind="tracker", seed=1, poses_per_plane=20, noise=5e-5)
    poses = scene.dataset.poses
    poses = poses.assign(q4=poses["q4"] / (1 + 1e-3))
    replace(scene.dataset, poses=poses).write(tmp_path / "my-cell")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("name", WITH_EXAMPLE)
def test_examples_run(my_cell: Path, name: str) -> None:
    """The example in a docstring gives what it shows."""
    found = doctest.DocTestFinder().find(getattr(scalar, name), name, globs={})
    examples = [test for test in found if test.examples]
    assert examples
    for test in examples:
        result = doctest.DocTestRunner().run(test)
        assert result.failed == 0


def test_the_readme_runs(my_cell: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The code under "As a library" runs as it stands, and names what was injected."""
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    match = re.search(r"## As a library\n\n```python\n(.*?)```", text, re.DOTALL)
    assert match
    assert len(match[1].splitlines()) <= 10
    exec(match[1], {})
    assert "joint_scale" in capsys.readouterr().out
    assert (my_cell / "calibration.json").exists()


def test_types_are_for_users_too() -> None:
    """The package says that it is typed (PEP 561), and ``make lint`` checks every module that defines one of its names strictly."""
    assert (ROOT / "scalar" / "py.typed").exists()
    with (ROOT / "pyproject.toml").open("rb") as file:
        strict = set(tomllib.load(file)["tool"]["pyright"]["strict"])
    modules = {f"{getattr(scalar, name).__module__.replace('.', '/')}.py" for name in scalar.__all__}
    assert modules | {"scalar/__init__.pyi"} <= strict
    assert all((ROOT / path).exists() for path in strict)
