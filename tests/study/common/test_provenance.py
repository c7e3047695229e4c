"""The version of the code in a table: a change of any source of the estimator or of the studies changes the checksum."""

import shutil
from pathlib import Path

import pytest
from study.common.provenance import code_version, sources_checksum

ROOT = Path(__file__).parents[3]


@pytest.fixture
def copies(tmp_path):
    """Return copies of both packages, without what is compiled."""
    ignore = shutil.ignore_patterns("__pycache__")
    sources = {"scalar": ROOT / "scalar", "study": ROOT / "workflow/study"}
    return [shutil.copytree(path, tmp_path / name, ignore=ignore) for name, path in sources.items()]


def test_the_checksum_is_that_of_a_copy(copies):
    """It depends on the names and contents of the sources alone, wherever they lie."""
    assert code_version()["sources_sha256"] == sources_checksum(*copies)


@pytest.mark.parametrize(
    "file",
    [
        "scalar/units.py",
        "study/blind_trials/score.py",
        "study/blind_trials/schemas/blind_trials.schema.json",
    ],
)
def test_a_change_in_either_package_changes_the_checksum(copies, file):
    """Changes of a schema and of a module that only the paper needs count too."""
    before = sources_checksum(*copies)
    path = copies[0].parent / file
    path.write_text(path.read_text(encoding="utf-8") + "\n", encoding="utf-8")
    assert sources_checksum(*copies) != before
