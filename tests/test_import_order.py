"""The order of the packages: each imports only packages below it, no two modules import each other, and the linter names what breaks this."""

import re
import tomllib
from pathlib import Path

import grimp
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
    """The imports keep every contract, those in functions and behind TYPE_CHECKING included, and a breach is printed with file and line."""
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


def package_of(module):
    """Return the part of the code that a module belongs to: the package or module directly in `scalar/`, or `study`; None for `scalar` itself."""
    parts = module.split(".")
    return parts[0] if parts[0] == "study" else parts[1] if len(parts) > 1 else None


def reached(edges, package, without):
    """Return the packages that can be reached from a package along edges (importing, imported), without one of the edges."""
    found, ahead = set(), [b for a, b in edges if a == package and (a, b) != without]
    while ahead:
        here = ahead.pop()
        if here not in found:
            found.add(here)
            ahead += [b for a, b in edges if a == here]
    return found


def test_the_picture_in_contributing_shows_the_imports():
    """CONTRIBUTING draws every package, and exactly the imports between packages that do not follow from others."""
    graph = grimp.build_graph("scalar", "study")
    imports = {(a, b) for a in graph.modules for b in graph.find_modules_directly_imported_by(a)}
    ignored = {tuple(text.split(" -> ")) for text in contracts()["order"].get("ignore_imports", [])}
    everywhere = {None, "errors", "units"}
    edges = {(package_of(a), package_of(b)) for a, b in imports - ignored}
    edges = {(a, b) for a, b in edges if a != b and not {a, b} & everywhere}
    needed = {edge for edge in edges if edge[1] not in reached(edges, edge[0], edge)}
    picture = (PROJECT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    picture = picture.split("```mermaid")[1].split("```")[0]
    assert set(re.findall(r"(?m)^ +(\w+)\[", picture)) == {package_of(m) for m in graph.modules} - everywhere
    assert set(re.findall(r"(\w+) --> (\w+)", picture)) == needed
