"""The modules of the studies: no file is too long, and imports have no circle."""

import ast
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

STUDY = Path(__file__).parents[2] / "workflow/study"
MODULES = {
    ".".join(path.relative_to(STUDY.parent).with_suffix("").parts).removesuffix(".__init__"): path
    for path in sorted(STUDY.rglob("*.py"))
}


def imported(path):
    """Return the names of the study's modules that a file imports anywhere, in functions and for types too."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            found |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
    return found & set(MODULES)


def test_imports_have_no_circle():
    """There is an order in which every module comes after all that it imports, where imports inside functions count."""
    order = list(TopologicalSorter({name: imported(path) for name, path in MODULES.items()}).static_order())
    assert set(order) == set(MODULES)
    assert order.index("study.common.grid") < order.index("study.sweeps.run")


def test_pictures_are_drawn_for_the_studies_and_import_none_that_computes():
    """No study imports the plots, and what the studies share imports no single study."""
    for name, path in MODULES.items():
        packages = {module.split(".")[1] for module in imported(path) if "." in module}
        if not name.startswith("study.plots"):
            assert "plots" not in packages, name
        if name.startswith("study.common"):
            assert packages <= {"common"}, name


@pytest.mark.parametrize("name", MODULES)
def test_a_file_has_one_idea(name):
    """Each file has fewer than 300 lines and a docstring."""
    text = MODULES[name].read_text(encoding="utf-8")
    assert len(text.splitlines()) < 300
    assert ast.get_docstring(ast.parse(text))


def test_every_module_stands_in_a_package_of_its_study():
    """No module stands directly in ``workflow/study``."""
    assert [path.name for path in STUDY.glob("*.py")] == ["__init__.py"]
