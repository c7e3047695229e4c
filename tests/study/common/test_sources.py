"""The modules listed as inputs are those that an import would load, wherever the statement stands."""

import subprocess
import sys
from pathlib import Path

from study.common.sources import source_files

ROOT = Path(__file__).parents[3]


def checkout(folder: Path, **modules: str) -> dict[str, Path]:
    """Write a package of modules, and return where it lies."""
    (folder / "ours/room").mkdir(parents=True)
    for name, text in {"__init__": "", "room/__init__": "", **modules}.items():
        (folder / f"ours/{name}.py").write_text(text)
    return {"ours": folder}


def test_imports_are_followed_from_module_to_module(tmp_path):
    """Every form of the import statement is followed, in functions too; names that are no module and packages of others are not."""
    homes = checkout(
        tmp_path,
        first="import json\n\ndef later():\n    from ours.room import second\n",
        third="",
        unrelated="import ours.first\n",
        **{"room/second": "from ours.third import NAME\nimport ours.first\n"},  # a circle ends as well
    )
    found = {str(path.relative_to(tmp_path / "ours")) for path in source_files(["ours.first"], homes)}
    assert found == {"__init__.py", "first.py", "room/__init__.py", "room/second.py", "third.py"}


def test_schemas_beside_a_module_come_with_it(tmp_path):
    """The schemas in the folder of a module are listed with it, since the module's behaviour depends on them."""
    homes = checkout(tmp_path, **{"room/reader": ""})
    schema = tmp_path / "ours/room/schemas/table.schema.json"
    schema.parent.mkdir()
    schema.write_text("{}")
    assert schema in source_files(["ours.room.reader"], homes)
    assert schema not in source_files(["ours"], homes)


def test_nothing_that_python_loads_is_missing():
    """Every file that Python has loaded after importing a step of the studies is among the files that are listed."""
    step = "study.sweeps.plans"
    program = (
        f"import sys, {step}\n"
        "print(*(m.__file__ for n, m in sys.modules.items() if n.split('.')[0] in ('scalar', 'study')), sep='\\n')"
    )
    loaded = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    ).stdout
    found = source_files([step], {"scalar": ROOT, "study": ROOT / "workflow"})
    assert len(loaded.split()) > 3
    assert set(map(Path, loaded.split())) <= found
