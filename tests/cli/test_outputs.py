"""What stands at the place of an output: the command's own earlier output is replaced, anything else only by --force, an input never."""

import json
import os

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner

from scalar.cli import cli
from scalar.estimation.calibrate import calibrate
from tests.random_scene import make_scene
from tests.robot_configs import ROBOT_CONFIGS


def run(*arguments):
    """Run ``scalar`` in this process."""
    return CliRunner().invoke(cli, [str(argument) for argument in arguments])


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Return a folder with a dataset of a tracker, a calibration and joint angles."""
    folder = tmp_path_factory.mktemp("made")
    scene = make_scene("vs060", "tracker", seed=2, poses_per_plane=20)
    scene.write(folder / "cell")
    calibrate(scene.dataset).save(folder / "calibration.json")
    q = np.random.default_rng(1).uniform(0.3, 0.9, (4, 6))
    table = pd.DataFrame(q, columns=[f"q{i + 1}" for i in range(6)])
    table.insert(0, "pose", range(4))
    table.to_csv(folder / "joints.csv", index=False)
    return folder


def commands(made, out):
    """Return commands by the file that each writes."""
    calibration, joints = made / "calibration.json", made / "joints.csv"
    plan = ("plan", "ur10e", "--poses", 20, "--candidates", 100, "--no-collisions", "-o", out / "plan")
    return {
        "frames.csv": ("predict", calibration, joints, "-o", out / "frames.csv"),
        "joints.csv": ("correct", calibration, joints, "-o", out / "joints.csv"),
        "arm.csv": ("export", calibration, "-o", out / "arm.csv"),
        "arm.md": ("export", calibration, "-o", out / "arm.md"),
        "changes.json": ("compare", calibration, calibration, "-o", out / "changes.json"),
        "fit/calibration.json": ("calibrate", made / "cell", "-o", out / "fit"),
        "plan/poses.csv": plan,
    }


@pytest.mark.parametrize("name", list(commands(ROBOT_CONFIGS, ROBOT_CONFIGS)))
def test_its_own_output_is_replaced_and_nothing_else(name, made, tmp_path):
    """An empty file and the command's earlier output are replaced.

    A file of others is kept, byte for byte, with exit status 2, unless --force is given.
    """
    command, path = commands(made, tmp_path)[name], tmp_path / name
    path.parent.mkdir(exist_ok=True)
    path.touch()
    for _ in range(2):
        result = run(*command)
        assert result.exit_code == 0, result.output
    ours = path.read_bytes()
    for other in path.parent.iterdir():  # a plan is known by its plan.json
        other.unlink()
    mine = "pose,speed\n1,250\n" if name.endswith(".csv") else json.dumps({"mine": 1})
    path.write_text(mine)
    result = run(*command)
    assert result.exit_code == 2 and "--force" in result.stderr and len(result.stderr.splitlines()) == 1
    assert path.read_text() == mine
    assert run(*command, "--force").exit_code == 0
    assert path.read_bytes() == ours


@pytest.mark.parametrize("name", list(commands(ROBOT_CONFIGS, ROBOT_CONFIGS)))
@pytest.mark.parametrize("linked", [False, True])
def test_a_pipe_at_the_place_of_an_output_stays(name, linked, made, tmp_path):
    """A pipe, or a link to one, is refused with exit status 2 and stays a pipe, even with --force."""
    path = tmp_path / name
    path.parent.mkdir(exist_ok=True)
    pipe = tmp_path / "pipe" if linked else path
    os.mkfifo(pipe)
    if linked:
        path.symlink_to(pipe)
    for more in ((), ("--force",)):
        result = run(*commands(made, tmp_path)[name], *more)
        assert result.exit_code == 2, result.output
        assert str(path) in result.stderr and "a pipe, a device or a socket" in result.stderr
        assert path.is_fifo() and path.is_symlink() == linked


def test_a_pipe_at_the_place_of_a_fleets_table_is_refused_before_anything_is_diagnosed(made, tmp_path):
    """The table is written last; what is in its place is looked at first."""
    os.mkfifo(tmp_path / "fleet.csv")
    result = run("diagnose", "--batch", made / "cell", "-o", tmp_path, "--quick")
    assert result.exit_code == 2 and "fleet.csv: cannot be written" in result.stderr
    assert list(tmp_path.iterdir()) == [tmp_path / "fleet.csv"]


def test_a_pipe_in_the_place_of_a_folder_is_refused(made, tmp_path):
    """A folder of results is not made where a pipe is."""
    os.mkfifo(tmp_path / "out")
    result = run("calibrate", made / "cell", "-o", tmp_path / "out")
    assert result.exit_code == 2 and "something else than a folder is there" in result.stderr
    assert (tmp_path / "out").is_fifo()


def test_an_input_is_never_an_output(made, tmp_path):
    """A command never replaces its own input, not even with --force."""
    joints = tmp_path / "joints.csv"
    joints.write_bytes((made / "joints.csv").read_bytes())
    for command in ("predict", "correct"):
        result = run(command, made / "calibration.json", joints, "-o", joints, "--force")
        assert result.exit_code == 2 and "is read by this command" in result.stderr
    assert joints.read_bytes() == (made / "joints.csv").read_bytes()


def test_a_plan_does_not_take_the_place_of_measured_poses(made):
    """A dataset's poses.csv is not taken for an earlier plan, and is not replaced."""
    before = (made / "cell" / "poses.csv").read_bytes()
    result = run("plan", made / "cell", "--candidates", 100, "--no-collisions", "-o", made / "cell")
    assert result.exit_code == 2 and "poses.csv" in result.stderr
    assert (made / "cell" / "poses.csv").read_bytes() == before


def test_a_dataset_is_replaced_while_nobody_has_changed_it(tmp_path):
    """A dataset is written again as long as it is unchanged; once a cell is edited it is replaced only with --force, and another folder never."""
    dataset = make_scene("vs060", "tracker", seed=2, poses_per_plane=4).dataset
    folder = tmp_path / "cell"
    for force in (False, False, True):
        dataset.write(folder, force=force)
    poses = folder / "poses.csv"
    ours = poses.read_text()
    poses.write_text(ours.replace("\n1,", "\n1001,", 1) if "\n1," in ours else ours + "\n")
    changed = poses.read_text()
    with pytest.raises(Exception, match="--force"):
        dataset.write(folder)
    assert poses.read_text() == changed
    dataset.write(folder, force=True)
    assert poses.read_text() == ours
    (folder / "notes.txt").write_text("mine")
    for force in (False, True):
        with pytest.raises(Exception, match=r"notes\.txt.*not even --force.*another place"):
            dataset.write(folder, force=force)


def test_a_table_is_not_written_under_the_name_of_a_spreadsheet(made, tmp_path):
    output = tmp_path / "frames.xlsx"
    result = run("predict", made / "calibration.json", made / "joints.csv", "-o", output)
    assert result.exit_code == 2 and "frames.csv" in result.output
    assert not output.exists()
