"""A disk that is really full, or read-only: a command says so in one line, an older result stays whole, and nothing half-written is left.

The disk is a small file system in memory, mounted for these tests; where that is not allowed they are skipped. Another dataset's result lies on it.
"""

import os
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.cli.running import INPUT_AT_FAULT, refused, run
from tests.endurance.kills import contents, hidden
from tests.random_scene import make_scene

SIZE = 4 * 1024**2  # bytes of the disk
LEFT = {"nothing": 0, "some files": 12 * 1024, "most files": 256 * 1024}  # bytes of it that are left
COMMANDS = {
    "calibrate": ("calibrate", "{data}/cell", "-o", "{out}/fit", "--report"),
    "diagnose": ("diagnose", "{data}/cell", "-o", "{out}/found", "--quick"),
    "plan": (
        *("plan", "{data}/cell", "--poses", "12", "--no-collisions", "--candidates", "100"),
        *("-o", "{out}/plan"),
    ),
    "predict": ("predict", "{data}/fit/calibration.json", "{data}/cell/poses.csv", "-o", "{out}/frames.csv"),
}


@pytest.fixture(scope="module")
def datasets(tmp_path_factory) -> tuple[Path, Path]:
    """Return two folders with a dataset of a tracker and its calibration each."""
    folders = []
    for seed, poses in (
        (1, 10),
        (2, 200),
    ):  # the second has the longer table of frames, which fills more than a block
        folder = tmp_path_factory.mktemp(f"seed-{seed}")
        make_scene("vs060", "tracker", seed=seed, poses_per_plane=poses).write(folder / "cell")
        assert run("calibrate", folder / "cell", "-o", folder / "fit").exit_code == 0
        folders.append(folder)
    return folders[0], folders[1]


@pytest.fixture
def disk(tmp_path: Path) -> Iterator[Path]:
    """Return the folder of a file system of its own."""
    folder = tmp_path / "disk"
    folder.mkdir()
    mount = shutil.which("mount")
    if mount is None or os.name != "posix":
        pytest.skip("there is no command mount")
    done = subprocess.run(
        [mount, "-t", "tmpfs", "-o", f"size={SIZE}", "tmpfs", str(folder)],
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode != 0:
        pytest.skip(f"mounting a file system is not allowed here: {done.stderr.strip()}")
    try:
        yield folder
    finally:
        subprocess.run(["umount", str(folder)], check=True)


def fill(folder: Path, left: int) -> Path:
    """Fill a file system but for some bytes, and return the file that fills it."""
    filler = folder / "filler"
    state = os.statvfs(folder)
    filler.write_bytes(bytes(max(state.f_bavail * state.f_frsize - left, 0)))
    return filler


def command(name: str, data: Path, out: Path) -> list[str]:
    """Return the arguments of a command."""
    return [part.format(data=data, out=out) for part in COMMANDS[name]]


@pytest.mark.parametrize("left", LEFT)
@pytest.mark.parametrize("name", COMMANDS)
def test_a_full_disk_leaves_the_older_result(name: str, left: str, datasets, disk: Path) -> None:
    """The command fails with one line or succeeds as a whole, and succeeds once there is room."""
    assert run(*command(name, datasets[0], disk)).exit_code == 0
    old = contents(disk)
    filler = fill(disk, LEFT[left])
    result = run(*command(name, datasets[1], disk))
    now = contents(disk)
    del now["filler"]
    if result.exit_code != 0 or left == "nothing":
        refused(result, INPUT_AT_FAULT, "No space left on device", "make room", lines=1)
        assert now == old
    assert not hidden(disk)
    filler.unlink()
    assert run(*command(name, datasets[1], disk)).exit_code == 0
    assert contents(disk) != old
    if result.exit_code == 0:
        assert contents(disk) == now


@pytest.mark.parametrize("name", COMMANDS)
def test_a_disk_that_may_not_be_written(name: str, datasets, disk: Path) -> None:
    """A file system that is read-only is refused with one line, and its content stays."""
    assert run(*command(name, datasets[0], disk)).exit_code == 0
    old = contents(disk)
    subprocess.run(["mount", "-o", "remount,ro", str(disk)], check=True)
    refused(run(*command(name, datasets[1], disk)), INPUT_AT_FAULT, "Read-only file system", lines=1)
    assert contents(disk) == old
    assert not hidden(disk)
