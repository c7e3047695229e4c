"""Which datasets ``scalar diagnose --batch`` finds below folders, in which order, and where the results of each stand."""

from __future__ import annotations

import errno
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from scalar.cli.fleet_folders import datasets_in, names_of
from tests.cli.fleets import run, table
from tests.random_scene import make_scene


def test_a_folder_without_a_dataset_has_a_line(tmp_path: Path) -> None:
    """A folder that is missing or holds no dataset is refused in its line, and is not passed over."""
    (tmp_path / "empty").mkdir()
    result = run("diagnose", "--batch", tmp_path / "empty", tmp_path / "nowhere", "-o", tmp_path / "out")
    rows = table(tmp_path / "out")
    assert result.exit_code == 2 and [row["status"] for row in rows.values()] == ["2", "2"]
    assert (
        "the folder is empty" in rows["empty"]["message"] and "no such folder" in rows["nowhere"]["message"]
    )


def test_a_folder_that_was_meant_as_a_dataset_has_a_line(
    tmp_path: Path, instantly: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Below a folder that is given, one that is empty, that links only to its parent, that cannot be read, or that lost its dataset.yaml has a line.

    A result of `plan` beside them, with poses.csv alone, has none, and neither have notes.
    """
    fleet = tmp_path / "fleet"
    for k, name in enumerate(("locked", "lost", "sound")):
        make_scene(kind="tracker", seed=k, poses_per_plane=9).write(fleet / name)
    (fleet / "lost" / "dataset.yaml").unlink()
    for name in ("circle", "empty", "notes", "plan"):
        (fleet / name).mkdir()
    (fleet / "circle" / "again").symlink_to("..")
    (fleet / "notes" / "readme.txt").write_text("measured on Friday", encoding="utf-8")
    (fleet / "plan" / "poses.csv").write_text("pose,q1\n1,0.5\n", encoding="utf-8")
    for name in ("listdir", "scandir"):  # permissions do not bind the user who runs the tests in a container
        monkeypatch.setattr(os, name, _refusing(getattr(os, name), fleet / "locked"))
    result = run("diagnose", "--batch", fleet, "-o", tmp_path / "out", "--quick")
    rows = table(tmp_path / "out")
    assert result.exit_code == 2 and "Traceback" not in result.output
    assert {name: row["status"] for name, row in rows.items()} == {
        **dict.fromkeys(("circle", "empty", "locked", "lost"), "2"),
        "sound": "0",
    }
    assert "the folder is empty" in rows["empty"]["message"]
    assert "Permission denied" in rows["locked"]["message"]
    assert "dataset.yaml: the file is missing" in rows["lost"]["message"]
    may = os.access
    monkeypatch.setattr(os, "access", lambda path, mode: Path(path).name != "locked" and may(path, mode))
    result = run("diagnose", "--batch", *sorted(fleet.iterdir()), "-o", tmp_path / "each", "--quick")
    assert result.exit_code == 2
    assert {name: row["status"] for name, row in table(tmp_path / "each").items()} == {
        name: "0" if name == "sound" else "2" for name in (*rows, "notes", "plan")
    }


def test_results_among_the_datasets_are_no_datasets(tmp_path: Path, instantly: list[str]) -> None:
    """An empty folder that a stopped run left among its results is passed over, where these lie below the folder that is given."""
    for k, name in enumerate(("one", "two")):
        make_scene(kind="tracker", seed=k, poses_per_plane=9).write(tmp_path / name)
    (tmp_path / "out" / "one").mkdir(parents=True)
    result = run("diagnose", "--batch", tmp_path, "-o", tmp_path / "out", "--quick")
    assert result.exit_code == 0, result.output
    assert list(table(tmp_path / "out")) == ["one", "two"]


def _refusing(function: Callable[[Any], Any], place: Path) -> Callable[[Any], Any]:
    """Return a function that lists folders, for which one folder may not be read."""

    def listed(folder: Any = ".") -> Any:
        if os.fspath(folder) == str(place):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(folder))
        return function(folder)

    return listed


PARTS = st.lists(st.sampled_from("abc"), min_size=1, max_size=3)


@given(st.sets(PARTS.map(lambda parts: Path("/", *parts)), min_size=1, max_size=8))
def test_each_result_has_a_folder_of_its_own(paths: set[Path]) -> None:
    """Whatever the folders are, each result has a folder outside all others, whose name ends as the dataset's does."""
    ordered = sorted(paths)
    names = names_of(ordered)
    assert len(set(names)) == len(names)
    for name, path in zip(names, ordered, strict=True):
        assert name.rsplit("/", 1)[-1].endswith(path.name)
        assert not any(other != name and f"{name}/".startswith(f"{other}/") for other in names)


def test_the_order_is_that_of_the_names(fleet: Path) -> None:
    """However the folders are given, even twice, each dataset has one line, in the order of names."""
    given_one_way = datasets_in([fleet / "robot-2", fleet / "robot-1", fleet / "robot-2" / "campaign"])
    assert given_one_way == datasets_in([fleet / "robot-1", fleet / "robot-2"])
    assert [path.parent.name for path in given_one_way] == ["robot-1", "robot-2"]
