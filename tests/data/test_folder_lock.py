"""Only one process at a time writes to a folder, and what killed processes left is removed."""

import errno
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from scalar.data.io.atomic import atomic_directory, atomic_write, cannot_write, write_together
from scalar.data.io.lock import LOCK, locked
from scalar.data.io.processes import lives
from scalar.data.io.temporary import sweep, temporary_beside
from scalar.errors import InvalidInput

HOLDS = """
import sys, time
from pathlib import Path
from scalar.data.io.atomic import atomic_write
from scalar.data.io.lock import locked
with locked(Path(sys.argv[1])) as folder, atomic_write(folder / "half.txt") as temporary:
    temporary.write_text("half")
    print("held", flush=True)
    time.sleep(600)
"""


@contextmanager
def holder(folder: Path) -> Iterator[subprocess.Popen[str]]:
    """Run another process that holds a folder, with a file half-written."""
    process = subprocess.Popen([sys.executable, "-c", HOLDS, folder], stdout=subprocess.PIPE, text=True)
    try:
        assert process.stdout is not None and process.stdout.readline() == "held\n"
        yield process
    finally:
        process.kill()
        process.communicate()


def test_a_living_owner_is_respected_and_named(tmp_path: Path) -> None:
    """While another process has locked a folder, it is refused with the number of that process, and its files stay as they are."""
    with holder(tmp_path) as process:
        before = sorted(os.listdir(tmp_path))
        with (
            pytest.raises(InvalidInput, match=f"process {process.pid} on .* wait") as caught,
            locked(tmp_path),
        ):
            pass
        assert caught.value.exit_status == 2
        assert sorted(os.listdir(tmp_path)) == before


@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGTERM])
def test_a_dead_owners_lock_is_taken_over_and_its_remains_are_swept(tmp_path: Path, how: int) -> None:
    """After a kill the lock is free at once, and what the owner had half-written is gone when the next one begins."""
    with holder(tmp_path) as process:
        process.send_signal(how)
        process.wait()
        assert len(os.listdir(tmp_path)) == 2  # the lock, and what was half-written
        with locked(tmp_path):
            assert os.listdir(tmp_path) == [LOCK]
            assert (tmp_path / LOCK).read_text().split()[0] == str(os.getpid())
    assert not os.listdir(tmp_path)


def test_a_process_cannot_lock_a_folder_twice(tmp_path: Path) -> None:
    """Although record locks do not exclude their own process, a second lock is refused; afterwards the folder is free."""
    with locked(tmp_path):
        with pytest.raises(InvalidInput, match=f"process {os.getpid()}"), locked(tmp_path):
            pass
        assert (tmp_path / LOCK).exists()
    with locked(tmp_path):
        pass


def test_a_folder_that_stays_empty_is_not_left(tmp_path: Path) -> None:
    """Folders that were made for a result that was not written are removed; folders that hold something stay."""
    with pytest.raises(KeyError), locked(tmp_path / "a" / "b"):
        raise KeyError
    assert not os.listdir(tmp_path)
    with locked(tmp_path / "a" / "b") as folder:
        (folder / "result").touch()
    assert os.listdir(tmp_path / "a" / "b") == ["result"]


def test_a_place_that_is_no_folder_is_refused(tmp_path: Path) -> None:
    """A file in the place of the folder or of its parent, and a name with a null character, are refused."""
    (tmp_path / "file").touch()
    for path in (tmp_path / "file", tmp_path / "file" / "below", Path("a\0b")):
        with pytest.raises(InvalidInput, match="cannot be written"), locked(path):
            pass


def dead_pid() -> int:
    """Return the number of a process that has ended."""
    process = subprocess.Popen([sys.executable, "-c", ""])
    process.wait()
    return process.pid


def as_if_by(pid: int, path: Path) -> Path:
    """Return a temporary name as another process would have given it."""
    return path.with_name(path.name.replace(f".{os.getpid()}.", f".{pid}."))


def test_only_files_of_ended_processes_of_this_machine_are_removed(tmp_path: Path) -> None:
    """Files of living processes and of other machines stay, and so do files whose names have another form."""
    dead = dead_pid()
    mine = temporary_beside(tmp_path / "a.json")
    left = as_if_by(dead, mine)
    parts = left.name.split(".")
    parts[3] = "000000" if parts[3] != "000000" else "000001"
    elsewhere = left.with_name(".".join(parts))
    others = [tmp_path / name for name in (".a.json.tmp", "a.json", f"..{dead}.tmp")]
    for path in (mine, left, elsewhere, *others):
        path.touch()
    (as_if_by(dead, temporary_beside(tmp_path / "folder"))).mkdir()
    sweep(tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {p.name for p in (mine, elsewhere, *others)}


@pytest.mark.parametrize("replaced", [False, True])
def test_a_folder_that_was_moved_aside_comes_back(tmp_path: Path, replaced: bool) -> None:
    """Killed between the two renames of an exchange, the old folder gets its name again, unless a new one has it."""
    aside = as_if_by(dead_pid(), temporary_beside(tmp_path / "data", "old"))
    aside.mkdir()
    (aside / "old").touch()
    if replaced:
        (tmp_path / "data").mkdir()
        (tmp_path / "data" / "new").touch()
    sweep(tmp_path)
    assert [p.name for p in tmp_path.rglob("*")] == ["data", "new" if replaced else "old"]


def test_writers_remove_what_killed_ones_left(tmp_path: Path) -> None:
    """Writing a single file or folder, which needs no lock, also removes what a killed writer has left there."""
    dead = dead_pid()
    for name, write in (("file", atomic_write), ("folder", atomic_directory)):
        place = tmp_path / f"of-{name}"
        place.mkdir()
        as_if_by(dead, temporary_beside(place / name)).touch()
        with write(place / name) as temporary:
            assert list(place.iterdir()) == [temporary]


def test_a_full_disk_is_reported_in_a_sentence(tmp_path: Path) -> None:
    """Wherever a full or broken disk stops the writing, one sentence says so, the old output is unchanged, and no temporary file stays."""
    (tmp_path / "out").write_text("old")
    for error in (28, 122, 27, 30):  # ENOSPC, EDQUOT, EFBIG, EROFS
        with pytest.raises(InvalidInput, match=r"cannot be written .* give another place"):
            with atomic_write(tmp_path / "out"):
                raise OSError(error, os.strerror(error))
        with pytest.raises(InvalidInput, match=r"cannot be written .* give another place"):
            with atomic_directory(tmp_path / "folder"):
                raise OSError(error, os.strerror(error))
    assert [p.name for p in tmp_path.iterdir()] == ["out"] and (tmp_path / "out").read_text() == "old"


WORKS = """
import os, sys, time
from scalar.data.io.processes import end_with
if os.fork() == 0:
    end_with(os.getppid())
    print(os.getpid(), flush=True)
    time.sleep(600)
os.wait()
"""


def test_a_worker_ends_with_the_process_it_works_for() -> None:
    """When the process it works for is killed, a worker ends within seconds."""
    process = subprocess.Popen([sys.executable, "-c", WORKS], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    worker = int(process.stdout.readline())
    process.kill()
    process.wait()
    process.stdout.close()
    until = time.monotonic() + 30
    while lives(worker) and Path(f"/proc/{worker}/stat").exists() and time.monotonic() < until:
        if Path(f"/proc/{worker}/stat").read_text().rpartition(")")[2].split()[0] == "Z":
            break
        time.sleep(0.1)
    else:
        assert not lives(worker)


def test_a_lock_that_cannot_be_written_leaves_nothing(tmp_path, monkeypatch):
    """On a full disk the folder is refused, and neither the lock nor the new folder stays."""

    def full(*_):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "pwrite", full)
    with pytest.raises(InvalidInput, match="make room"), locked(tmp_path / "new"):
        pytest.fail("the folder was locked")
    assert not list(tmp_path.iterdir())


def test_no_file_of_a_result_is_replaced_unless_all_can_be_written(tmp_path):
    """If one of them cannot be written, those before and after it are as they were, and nothing hidden is left."""
    write_together(tmp_path, {"first": "1", "second": "2"})
    (tmp_path / "third").mkdir()
    for names in (("first", "third", "second"), ("third", "first"), ("first", "third")):
        with pytest.raises(InvalidInput, match="third"):
            write_together(tmp_path, dict.fromkeys(names, "new"))
    assert {path.name: path.read_text() for path in tmp_path.iterdir() if path.is_file()} == {
        "first": "1",
        "second": "2",
    }
    write_together(tmp_path, {"first": "one", "second": "two"})
    assert (tmp_path / "second").read_text() == "two"


def test_a_file_of_a_folder_that_cannot_be_written_is_named_by_its_place(tmp_path):
    """The message names the file as it was to be called, not the hidden folder in which it is written first."""
    with pytest.raises(InvalidInput) as raised, atomic_directory(tmp_path / "cell") as folder:
        raise cannot_write(folder / "dataset.yaml", OSError(errno.ENOSPC, os.strerror(errno.ENOSPC)))
    assert [fault.file for fault in raised.value.faults] == [str(tmp_path / "cell" / "dataset.yaml")]
    assert not list(tmp_path.iterdir())
