"""Only regular files of a limited length are read: no reader waits for a pipe, and no device fills the memory."""

import os
import socket
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from scalar.data.dataset import read_dataset
from scalar.data.dataset_writer import write_dataset
from scalar.data.io.atomic import write_json
from scalar.data.io.json_reader import read_json
from scalar.data.io.plain_yaml import load_yaml
from scalar.data.io.regular_file import check_regular_file, read_regular_file, refuse_special
from scalar.data.pose_tables import read_pose_table
from scalar.errors import InvalidInput
from scalar.ingest.foreign_tables import read_raw
from tests.small_datasets import description, tables

READERS: dict[str, Callable[[Path], Any]] = {
    "yaml": load_yaml,
    "json": read_json,
    "csv": lambda path: read_pose_table(path, 6),
    "foreign": lambda path: read_raw(path, {}, None),
    "mat": lambda path: read_raw(path, {}, None),
}


def place(reader: str, folder: Path) -> Path:
    """Return a path whose ending is that of the reader's files."""
    return folder / f"file.{ {'foreign': 'txt'}.get(reader, reader) }"


@pytest.mark.parametrize("reader", READERS)
def test_a_pipe_is_refused_by_every_reader(reader: str, tmp_path: Path) -> None:
    """A pipe that nobody writes to is refused at once."""
    path = place(reader, tmp_path)
    os.mkfifo(path)
    with pytest.raises(InvalidInput, match="not a regular file"):
        READERS[reader](path)


@pytest.mark.parametrize("reader", READERS)
def test_a_link_to_an_endless_device_is_refused_by_every_reader(reader: str, tmp_path: Path) -> None:
    """A link to a device without an end is refused before a byte is read."""
    path = place(reader, tmp_path)
    path.symlink_to("/dev/zero")
    with pytest.raises(InvalidInput, match="not a regular file"):
        READERS[reader](path)


@pytest.mark.parametrize("reader", READERS)
def test_a_null_character_in_a_path_is_refused_by_every_reader(reader: str, tmp_path: Path) -> None:
    """A path with a null character, which a mapping file may name, is refused."""
    with pytest.raises(InvalidInput, match=r"not a path|no such file"):
        READERS[reader](place(reader, tmp_path / "a\0b"))


@pytest.mark.parametrize("reader", READERS)
def test_a_file_beyond_its_limit_is_refused_before_it_is_read(reader: str, tmp_path: Path) -> None:
    """A (sparse) file of two gigabytes is refused, and the message states the limit."""
    path = place(reader, tmp_path)
    with path.open("wb") as file:
        file.truncate(2_000_000_000)
    with pytest.raises(InvalidInput, match=r"longer than \d+ MB"):
        READERS[reader](path)


@pytest.mark.parametrize("file", ["dataset.yaml", "poses.csv", "scans.csv", "scans.parquet"])
def test_a_pipe_in_a_dataset_is_refused(file: str, tmp_path: Path) -> None:
    """A pipe in the place of any file of a dataset is a fault of that file."""
    folder = tmp_path / "d"
    kind = "parquet" if file.endswith("parquet") else "csv"
    write_dataset(folder, mapping=description(), table_format=kind, **tables())
    (folder / file).unlink()
    os.mkfifo(folder / file)
    with pytest.raises(InvalidInput) as caught:
        read_dataset(folder)
    assert [fault.file for fault in caught.value.faults if "not a regular file" in fault.message] == [file]


def test_a_file_of_just_the_limit_is_read(tmp_path: Path) -> None:
    """A file of exactly the limit is read, one of a byte more is refused, and so is a folder."""
    path = tmp_path / "file"
    path.write_bytes(b"abc")
    assert read_regular_file(path, 3) == b"abc"
    check_regular_file(path, 3)
    for most, wrong in ((2, path), (3, tmp_path)):
        with pytest.raises(InvalidInput):
            read_regular_file(wrong, most)


def test_a_place_with_something_special_is_refused_for_an_output(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A folder, a pipe, a socket and a link of the system's devices may not be replaced by an output; a file, a link to one and nothing may."""
    monkeypatch.chdir(tmp_path)  # the path of a socket may not be long
    (tmp_path / "folder").mkdir()
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "file").touch()
    (tmp_path / "link").symlink_to("file")
    (tmp_path / "dangling").symlink_to("nowhere")
    for name in ("file", "link", "dangling", "nothing", "file/below"):
        refuse_special(tmp_path / name)
    with socket.socket(socket.AF_UNIX) as server:
        server.bind("socket")
        # This function only looks; it is not tried with a writer what becomes of devices.
        for place in (tmp_path / "folder", tmp_path / "pipe", tmp_path / "socket", Path("/dev/stdout")):
            with pytest.raises(InvalidInput, match="cannot be written"):
                refuse_special(place)


@pytest.mark.parametrize("special", [os.mkfifo, os.mkdir])
def test_no_output_takes_the_place_of_a_pipe_or_a_folder(
    special: Callable[[Path], None], tmp_path: Path
) -> None:
    """What is there stays, and no temporary file is left."""
    path = tmp_path / "out.json"
    special(path)
    kind = path.stat().st_mode
    with pytest.raises(InvalidInput, match="cannot be written"):
        write_json(path, {})
    assert path.stat().st_mode == kind
    assert list(tmp_path.iterdir()) == [path]
