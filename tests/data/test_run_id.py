"""Files of two runs are not taken for one result."""

from pathlib import Path

import pytest

from scalar.data.io.atomic import write_json
from scalar.data.io.run_id import DIAGNOSIS_FILES, INDEX, check_run, run_of, with_run
from scalar.errors import InvalidInput

RESULTS = {name: {"format": "scalar-something/2", "value": k} for k, name in enumerate(DIAGNOSIS_FILES)}


def write(folder: Path, run: str, names: tuple[str, ...] = DIAGNOSIS_FILES) -> None:
    """Write files of one run."""
    for name in names:
        write_json(folder / name, with_run(RESULTS[name], run))


def test_the_same_findings_are_the_same_run() -> None:
    """The name of a run depends on the content of all its files, and on nothing else."""
    assert run_of(*RESULTS.values()) == run_of(*RESULTS.values())
    assert len({run_of({"a": 1}), run_of({"a": 2}), run_of({"a": 1}, {}), run_of({"b": 1})}) == 4


@pytest.mark.parametrize("written", range(len(DIAGNOSIS_FILES) + 1))
def test_a_run_killed_after_any_file_is_noticed_by_whoever_reads_one(tmp_path: Path, written: int) -> None:
    """If a second run replaced only the first files, each of these is refused, and so is the index."""
    write(tmp_path, "0" * 16)
    write(tmp_path, "1" * 16, DIAGNOSIS_FILES[:written])
    for k, name in enumerate(DIAGNOSIS_FILES):
        mixed = 0 < written < len(DIAGNOSIS_FILES)
        if mixed and (name == INDEX or k < written):
            with pytest.raises(InvalidInput, match=r"of run 1.* of run 0|of run 0.* of run 1"):
                check_run(tmp_path / name)
        else:
            check_run(tmp_path / name)


def test_what_names_no_run_or_stands_alone_is_read(tmp_path: Path) -> None:
    """Files of earlier releases, copies under other names, and files next to an index without a run are accepted."""
    write(tmp_path, "1" * 16)
    write_json(tmp_path / INDEX, RESULTS[INDEX])
    (tmp_path / "after.json").rename(tmp_path / "mine.json")
    for name in ("before.json", "mine.json", INDEX):
        check_run(tmp_path / name)
