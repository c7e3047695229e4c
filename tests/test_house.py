"""The order of the rooms: a package imports only what stands below it, no two modules import each other, and the linter would say so."""

import re
import tomllib
from pathlib import Path

import pytest
from importlinter.cli import lint_imports

PROJECT = Path(__file__).parents[1]
PYPROJECT = PROJECT / "pyproject.toml"


def contracts():
    """Return the contracts of pyproject.toml by id."""
    settings = tomllib.loads(PYPROJECT.read_text(encoding="utf-8"))["tool"]["importlinter"]
    return {contract["id"]: contract for contract in settings["contracts"]}


@pytest.mark.parametrize("contract", sorted(contracts()))
def test_the_imports_keep_the_contract(contract, capsys):
    """Imports in functions and behind TYPE_CHECKING count; what breaks a contract is printed with file and line."""
    status = lint_imports(str(PYPROJECT), limit_to_contracts=(contract,), no_cache=True)
    assert status == 0, capsys.readouterr().out


def test_an_import_that_runs_upwards_would_be_named(tmp_path, capsys):
    """With the order reversed, the linter refuses the same code and names imports that then run upwards."""
    text = PYPROJECT.read_text(encoding="utf-8")
    layers = contracts()["order"]["layers"]
    listed = re.search(r"(?s)\nlayers = \[\n.*?\n\]", text)
    assert listed is not None
    reverse = "\nlayers = [\n" + "".join(f'    "{layer}",\n' for layer in reversed(layers)) + "]"
    upside_down = tmp_path / "pyproject.toml"
    upside_down.write_text(text.replace(listed.group(0), reverse), encoding="utf-8")
    assert lint_imports(str(upside_down), limit_to_contracts=("order",), no_cache=True) == 1
    said = " ".join(capsys.readouterr().out.split())
    assert "scalar.estimation is not allowed to import scalar.geometry" in said


def test_every_package_has_its_place():
    """All that stands directly in `scalar/` is in the order, except the simulator, which has contracts of its own."""
    placed = {name.strip() for layer in contracts()["order"]["layers"] for name in layer.split("|")}
    found = {path.stem for path in (PROJECT / "scalar").iterdir() if path.suffix == ".py" or path.is_dir()}
    assert found - {"__init__", "__pycache__", "simulation"} == placed
