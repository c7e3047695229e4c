"""What a command imports: nothing that it does not use, since that is most of what a short command costs."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from scalar.data.dataset import read_dataset
from scalar.data.dataset_writer import write_dataset
from scalar.estimation.result import Calibration
from tests import small_datasets

SLOW = (
    "jinja2",
    "jsonschema",
    "lmfit",
    "lxml",
    "matplotlib",
    "numpy",
    "pandas",
    "pyarrow",
    "pybullet",
    "rich",
    "ruamel",
    "scipy",
)
"""The libraries that take a noticeable time to import."""

RUN = """
import json, sys
from scalar.cli import cli
try:
    cli(sys.argv[1:], prog_name="scalar")
except SystemExit as end:
    status = end.code
print(json.dumps([status, sorted({name.partition(".")[0] for name in sys.modules})]))
"""


def imported_by(*arguments: str) -> set[str]:
    """Return which slow libraries the process of a command has imported at its end."""
    run = subprocess.run([sys.executable, "-c", RUN, *arguments], capture_output=True, text=True, check=True)
    status, names = json.loads(run.stdout.splitlines()[-1])
    assert status in (0, None), run.stderr
    return set(names) & set(SLOW)


@pytest.fixture
def dataset(tmp_path: Path) -> Path:
    """Return the folder of a small dataset."""
    mapping = small_datasets.description("tracker")
    write_dataset(tmp_path / "d", mapping=mapping, **small_datasets.tables("tracker"))
    return tmp_path / "d"


@pytest.mark.parametrize(
    "arguments",
    [
        ("--help",),
        ("--version",),
        *(
            (name, "--help")
            for name in ("calibrate", "diagnose", "evaluate", "import", "predict", "simulate", "validate")
        ),
    ],
    ids=" ".join,
)
def test_help_imports_no_library(arguments: tuple[str, ...]) -> None:
    """Help and version import none of the slow libraries, since a short command should cost no more than click does."""
    assert imported_by(*arguments) == set()


def test_validating_imports_the_readers_alone(dataset: Path) -> None:
    """Checking a dataset imports the readers of YAML and CSV, and no data frame, solver or picture."""
    assert imported_by("validate", str(dataset)) <= {"jsonschema", "numpy", "pyarrow", "ruamel"}


def test_predicting_imports_no_solver(dataset: Path, tmp_path: Path) -> None:
    """Predicting imports neither the least-squares library, nor what draws and writes reports."""
    Calibration.nominal(read_dataset(dataset)).save(tmp_path / "calibration.json")
    arguments = ("predict", str(tmp_path / "calibration.json"), str(dataset / "poses.csv"))
    found = imported_by(*arguments, "-o", str(tmp_path / "frames.csv"))
    assert "pandas" in found  # the check can fail: what is used is seen
    assert found.isdisjoint({"jinja2", "lmfit", "matplotlib", "pybullet", "rich"})


def test_a_command_computes_with_one_thread_whatever_its_surroundings_say():
    """With two threads of BLAS the same diagnosis had other last digits, and so another number of its run."""
    names = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
    code = f"import os, scalar.cli; print(*(os.environ[name] for name in {names}))"
    surroundings = {**os.environ, **dict.fromkeys(names, "2")}
    ran = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, env=surroundings
    )
    assert ran.stdout.split() == ["1", "1", "1"]
