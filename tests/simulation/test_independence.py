"""The simulator proves nothing if it shares its formulas with what is fitted to its data."""

import ast
from pathlib import Path

import scalar.simulation

ALLOWED = {
    "scalar.units",
    "scalar.errors",
    "scalar.data.io.atomic",
    "scalar.data.io.plain_yaml",
    "scalar.data.io.run_id",
    "scalar.data.dataset",
    "scalar.data.dataset_writer",
    "scalar.data.formats",
    "scalar.data.schema_words",
    "scalar.data.strict_schema",
}
FOLDER = Path(scalar.simulation.__file__).parent


def imported(path):
    """Return the names of the modules that a file imports."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield node.module or "."


def test_the_simulator_imports_nothing_of_the_estimator():
    """Of the package, the simulator uses units, errors and file formats only, so that no inverse crime is possible."""
    for path in FOLDER.rglob("*.py"):
        ours = {name for name in imported(path) if name == "." or name.split(".")[0] == "scalar"}
        assert {name for name in ours if not name.startswith("scalar.simulation")} <= ALLOWED, path.name
