"""Outputs appear whole or not at all, and leave no temporary files."""

import json
from pathlib import Path

import numpy as np
import pytest

from scalar.data.io.atomic import atomic_directory, atomic_write, plain, write_json
from scalar.errors import InvalidInput


class Interrupted(Exception):
    """Stands for anything that stops a writer half-way."""


@pytest.mark.parametrize("old", [None, "old"])
def test_an_interrupted_file_leaves_what_was_there(tmp_path: Path, old: str | None) -> None:
    """After a failure the old content is there, or nothing, and no temporary file."""
    path = tmp_path / "out.txt"
    if old is not None:
        path.write_text(old)
    with pytest.raises(Interrupted), atomic_write(path) as temporary:
        temporary.write_text("half")
        raise Interrupted
    assert [item.name for item in tmp_path.iterdir()] == ([] if old is None else ["out.txt"])
    assert old is None or path.read_text() == old


def test_a_file_is_not_there_before_it_is_complete(tmp_path: Path) -> None:
    """The destination appears at the end of the block; missing folders are made."""
    path = tmp_path / "new" / "out.txt"
    with atomic_write(path) as temporary:
        temporary.write_text("whole")
        assert not path.exists()
    assert path.read_text() == "whole"
    assert len(list(path.parent.iterdir())) == 1


@pytest.mark.parametrize("replaced", [False, True])
def test_an_interrupted_folder_leaves_what_was_there(tmp_path: Path, replaced: bool) -> None:
    """After a failure the old folder is there, or nothing, and no temporary folder."""
    path = tmp_path / "out"
    if replaced:
        path.mkdir()
        (path / "old").touch()
    with pytest.raises(Interrupted), atomic_directory(path, lambda _: True) as temporary:
        (temporary / "half").touch()
        raise Interrupted
    assert [item.name for item in tmp_path.rglob("*")] == (["out", "old"] if replaced else [])


def test_a_folder_replaces_another_only_if_it_may(tmp_path: Path) -> None:
    """Without permission a folder that is not empty is refused and left as it is; with permission it is replaced."""
    path = tmp_path / "out"
    path.mkdir()
    (path / "precious").touch()
    with pytest.raises(InvalidInput, match="already there"), atomic_directory(path):
        pass
    assert (path / "precious").exists()
    with atomic_directory(path, lambda _: True) as temporary:
        (temporary / "new").touch()
    assert [item.name for item in tmp_path.rglob("*")] == ["out", "new"]


def test_a_place_that_cannot_be_written_is_the_users_fault(tmp_path: Path) -> None:
    """A folder in the place of the file, or a file in the place of the folder, is refused with a message, not a traceback."""
    (tmp_path / "file").touch()
    for path in (tmp_path, tmp_path / "file" / "below"):
        with pytest.raises(InvalidInput, match="cannot be written"), atomic_write(path):
            pass
    with pytest.raises(InvalidInput, match="already there"), atomic_directory(tmp_path / "file"):
        pass


def test_json_holds_finite_numbers_or_null(tmp_path: Path) -> None:
    """NaN and infinities become null; finite floats read back exactly; the order of keys is kept."""
    third = 1.0 / 3.0
    write_json(tmp_path / "a.json", {"z": np.array([third, np.nan]), "a": (np.int64(3), -np.inf), "µ": None})
    text = (tmp_path / "a.json").read_text(encoding="utf-8")
    assert json.loads(text) == {"z": [third, None], "a": [3, None], "µ": None}
    assert list(json.loads(text)) == ["z", "a", "µ"]
    assert text.endswith("}\n")


def test_what_has_no_plain_form_is_refused() -> None:
    """An object is refused, not written as text."""
    with pytest.raises(TypeError, match="no plain form"):
        plain({"a": object()})


@pytest.mark.parametrize("full", [False, True])
def test_a_link_to_a_folder_stays_a_link(tmp_path: Path, full: bool) -> None:
    """The folder to which an output leads is replaced, on whatever disk it is; once the link was, and was left under a hidden name."""
    there, link = tmp_path / "disk" / "there", tmp_path / "out"
    there.mkdir(parents=True)
    if full:
        (there / "old").touch()
    link.symlink_to(there, target_is_directory=True)
    with atomic_directory(link, lambda _: True) as temporary:
        (temporary / "new").touch()
    assert link.is_symlink()
    assert sorted(str(p.relative_to(tmp_path)) for p in (tmp_path / "disk").rglob("*")) == [
        "disk/there",
        "disk/there/new",
    ]
    assert sorted(p.name for p in tmp_path.iterdir()) == ["disk", "out"]


def test_a_circle_of_links_is_refused(tmp_path: Path) -> None:
    """A place that leads to itself is no place for an output, and no fault of the program."""
    (tmp_path / "circle").symlink_to("circle")
    for path in (tmp_path / "circle", tmp_path / "circle" / "out"):
        with pytest.raises(InvalidInput, match="cannot be written"), atomic_directory(path):
            pass
    assert [p.name for p in tmp_path.iterdir()] == ["circle"]
