"""What is known of an effect is known in its own file, and nowhere else in the estimator."""

import ast
import re
from pathlib import Path

import pytest

import scalar
from scalar.effects import registry
from scalar.effects.effect import Effect

ROOT = Path(scalar.__file__).parent
PACKAGES = ("estimation", "diagnosis", "report", "cli")
FILES = [path for package in PACKAGES for path in sorted((ROOT / package).rglob("*.py"))]
ALSO_A_VERDICT = {
    "unattributed"
}  # diagnosis.json's word for unmodelled structure, as a verdict and as an entry


def kinds_below(kind):
    """Return every concrete effect of the package below a class."""
    for sub in kind.__subclasses__():
        if sub.__module__.startswith("scalar.") and hasattr(sub, "name"):
            yield sub
        yield from kinds_below(sub)


CLASSES = {kind.__name__ for kind in kinds_below(Effect)}
NAMES = {kind.name for kind in registry.BUILT_IN} - ALSO_A_VERDICT


def test_the_check_knows_the_effects():
    """The check looks for the names of the registry and of the flexible terms, so that it leaves no effect out."""
    assert {kind.__name__ for kind in registry.BUILT_IN} <= CLASSES
    assert {"UnattributedWave", "UnattributedSway"} <= CLASSES
    assert len(NAMES) == len(registry.BUILT_IN) - 1


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(ROOT)))
def test_no_effect_is_named(path):
    """The code outside an effect's own file contains neither its class nor its name; examples in docstrings may."""
    tree = ast.parse(path.read_text())
    prose = {
        id(node.value)
        for node in ast.walk(tree)
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
    }
    for node in ast.walk(tree):
        if isinstance(node, ast.Name):
            assert node.id not in CLASSES, f"line {node.lineno}"
        elif isinstance(node, ast.ImportFrom):
            assert not CLASSES & {alias.name for alias in node.names}, f"line {node.lineno}"
        elif isinstance(node, ast.Attribute):
            assert node.attr not in CLASSES, f"line {node.lineno}"
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in prose:
            assert not NAMES & set(re.findall(r"\w+", node.value)), f"line {node.lineno}"


def test_every_effect_states_its_natural_size_and_where_it_is_from():
    """Every kind with a name has a natural size for each of its units, with a source or the word that it is assumed."""
    for kind in registry.BUILT_IN:
        if not kind.flexible:
            assert kind.natural and all(size > 0 for size in kind.natural.values()), kind.name
            assert len(kind.natural_source) > 20, kind.name
