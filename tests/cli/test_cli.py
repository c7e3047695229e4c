"""The command line: end to end on a cell of the tests' own, and every refusal with its exit status, a
line a fault, nothing left.
"""

import json
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner, Result

from scalar.cli import cli
from scalar.data.dataset_writer import write_dataset
from tests import kinematics
from tests.kinematics import joint_names
from tests.random_scene import make_scene
from tests.small_datasets import edit_cell, edit_lines
from tests.workcell import Scene

INPUT_AT_FAULT, UNDETERMINED = 2, 3
FLOOR, WALL = np.array([0.0, 0, 1]), np.array([1.0, 0, 0])


def run(*arguments: object) -> Result:
    """Run ``scalar`` in this process."""
    return CliRunner().invoke(cli, [str(argument) for argument in arguments])


def refused(
    result: Result, status: int, *words: str, output: Path | None = None, lines: int | None = None
) -> None:
    """Check a refusal: its status, one line a fault on stderr, the words, no traceback, and no output."""
    assert result.exit_code == status, result.output
    assert isinstance(result.exception, SystemExit)
    assert result.stdout == ""
    said = result.stderr.splitlines()
    assert said and all(line.startswith("scalar: ") for line in said)
    assert "Traceback" not in result.stderr
    if lines is not None:
        assert len(said) == lines, result.stderr
    for word in words:
        assert word in result.stderr
    if output is not None:
        assert not output.exists()


@pytest.fixture(scope="module")
def scene() -> Scene:
    """A cell that calibrates well."""
    return make_scene(seed=21, poses_per_plane=30, points_per_scan=20)


@pytest.fixture(scope="module")
def sound(scene, tmp_path_factory) -> Path:
    """Return a folder with dataset, truth, calibration and joints.csv, all sound."""
    folder = tmp_path_factory.mktemp("sound")
    scene.write(folder / "dataset")
    scene.write_truth(folder / "truth", np.random.default_rng(0))
    scene.truth.poses(5, np.random.default_rng(1)).iloc[:, :7].to_csv(folder / "joints.csv", index=False)
    result = run("calibrate", folder / "dataset", "-o", folder / "out")
    assert result.exit_code == 0, result.output
    (folder / "summary.txt").write_text(result.stdout, encoding="utf-8")
    return folder


@pytest.fixture
def dataset(sound, tmp_path) -> Path:
    """Return a copy of the dataset, to be spoilt."""
    return Path(shutil.copytree(sound / "dataset", tmp_path / "dataset"))


def test_validate_says_what_a_dataset_holds(sound):
    """Robot, sensor, poses by plane and points, on stdout, exit status 0."""
    result = run("validate", sound / "dataset")
    assert result.exit_code == 0
    for words in ("vs060", "line-laser", "90 poses", "floor 30", "1800 points"):
        assert words in result.stdout


def test_calibrate_says_what_was_found_how_sure_and_what_could_not_be_seen(sound):
    """The summary has the residual, every free geometric parameter with its std, the sensor, the planes
    and the gauge.
    """
    text = (sound / "summary.txt").read_text(encoding="utf-8")
    free = json.loads((sound / "out" / "calibration.json").read_text())["parameters"]
    for name, entry in free.items():
        assert (name in text) or not entry["held"] or name.startswith("beta"), name
    for words in (
        "90 poses",
        "residual",
        "std",
        "sensor on flange",
        "plane floor",
        "d_6",
        "the data do not show where the base is",
    ):
        assert words in text
    assert [path.name for path in (sound / "out").iterdir()] == ["calibration.json"]


def test_predict_writes_the_true_frames_to_within_the_noise(sound, scene, tmp_path):
    """Columns and ids as interfaces.md has them; frames within 0.2 mm of the truth; the same bytes each
    time.
    """
    for name in ("one.csv", "two.csv"):
        result = run(
            "predict", sound / "out/calibration.json", sound / "joints.csv", "-o", tmp_path / "new" / name
        )
        assert result.exit_code == 0, result.output
    frames = pd.read_csv(tmp_path / "new/one.csv")
    assert list(frames.columns) == ["pose", "x", "y", "z", "rx", "ry", "rz"]
    joints = pd.read_csv(sound / "joints.csv")
    assert frames["pose"].tolist() == joints["pose"].tolist()
    T = scene.truth.sensor(joints[joint_names(6)].to_numpy())
    assert np.abs(frames[["x", "y", "z"]].to_numpy() - T[:, :3, 3]).max() < 2e-4
    for i, turn in enumerate(frames[["rx", "ry", "rz"]].to_numpy()):
        R = kinematics.rotate_about(turn, float(np.linalg.norm(turn)))
        assert np.linalg.norm(kinematics.rotation_vector(R @ T[i, :3, :3].T)) < 1e-3
    assert (tmp_path / "new/one.csv").read_bytes() == (tmp_path / "new/two.csv").read_bytes()


def test_evaluate_compares_with_the_truth(sound, tmp_path):
    """Raw and aligned, mean and maximum, in the file and on the terminal."""
    result = run("evaluate", sound / "out/calibration.json", sound / "truth", "-o", tmp_path / "e")
    assert result.exit_code == 0, result.output
    assert "raw" in result.stdout and "aligned" in result.stdout
    content = json.loads((tmp_path / "e" / "evaluation.json").read_text())
    assert content["poses"] == 500
    assert content["raw"]["position_mean_mm"] < 0.1
    assert content["aligned"]["position_mean_mm"] <= content["raw"]["position_mean_mm"] * 1.01
    assert len(content["planes"]) == 3 and len(content["parameters"]) == 36


def test_the_same_input_gives_the_same_bytes(sound, tmp_path):
    """A calibration run again is the same file."""
    assert run("calibrate", sound / "dataset", "-o", tmp_path).exit_code == 0
    again = (tmp_path / "calibration.json").read_bytes()
    assert again == (sound / "out/calibration.json").read_bytes()


@pytest.mark.parametrize("kind", ["probe", "tracker"])
def test_other_sensors_go_through(kind, tmp_path):
    """A probe's and a tracker's dataset from folder to frames."""
    scene = make_scene("panda", kind, poses_per_plane=40)
    scene.write(tmp_path / "dataset")
    result = run("calibrate", tmp_path / "dataset", "-o", tmp_path / "out")
    assert result.exit_code == 0, result.output
    scene.truth.poses(5, np.random.default_rng(1)).to_csv(tmp_path / "joints.csv", index=False)
    result = run(
        "predict", tmp_path / "out/calibration.json", tmp_path / "joints.csv", "-o", tmp_path / "frames.csv"
    )
    assert result.exit_code == 0, result.output


@pytest.mark.parametrize(
    "command", ["simulate", "validate", "calibrate", "diagnose", "predict", "correct", "export", "evaluate"]
)
def test_help_shows_an_example(command):
    """Each command's help ends with a command line to copy."""
    result = run(command, "--help")
    assert result.exit_code == 0
    assert "Example" in result.stdout
    assert f"scalar {command} " in result.stdout.split("Example", 1)[1]


def test_help_of_all_names_every_command_and_status():
    """``scalar --help`` leads from a dataset to frames and says what the exit statuses mean."""
    text = run("--help").stdout
    for words in (
        "simulate",
        "validate",
        "calibrate",
        "diagnose",
        "predict",
        "export",
        "evaluate",
        "Exit status",
    ):
        assert words in text
    assert run("--version").stdout.startswith("scalar")


# --- what the data cannot determine, or the user got wrong: datasets that are well-formed ---


def in_cell(**settings) -> Scene:
    """Return a quick cell."""
    return make_scene(**{"points_per_scan": 12, "seed": 3, **settings})


def only(scene: Scene, rows: np.ndarray) -> Scene:
    """Return the scene with some of its poses, each with an id of its own."""
    data = scene.dataset.subset(rows)
    poses = data.poses.assign(pose=np.arange(1, data.n_poses + 1))
    return replace(scene, dataset=replace(data, poses=poses))


def line_on_a_wall() -> Scene:
    """Return a cell in which one wall is scanned from a single pose, again and again."""
    scene = in_cell()
    index = scene.dataset.plane_index
    return only(
        scene, np.sort(np.r_[np.flatnonzero(index != 2), np.repeat(np.flatnonzero(index == 2)[0], 20)])
    )


def contacts_on_a_line() -> Scene:
    """Return a probe's cell in which one wall is touched in two places only."""
    scene = in_cell(kind="probe")
    index = scene.dataset.plane_index
    return only(
        scene, np.sort(np.r_[np.flatnonzero(index != 2), np.repeat(np.flatnonzero(index == 2)[:2], 20)])
    )


def declared_parallel() -> Scene:
    """Return a cell whose dataset.yaml says that two walls are parallel, while the scans say otherwise."""
    scene = in_cell()
    floor, wall_x, wall_y = scene.dataset.planes
    planes = (floor, wall_x, replace(wall_y, normal=wall_x.normal))
    return replace(scene, dataset=replace(scene.dataset, planes=planes))


def swapped_names() -> Scene:
    """Return a cell whose two walls have each other's name in poses.csv."""
    scene = in_cell()
    other = scene.dataset.poses["plane"].map({"floor": "floor", "wall_x": "wall_y", "wall_y": "wall_x"})
    return replace(scene, dataset=replace(scene.dataset, poses=scene.dataset.poses.assign(plane=other)))


PARALLEL = (np.array([FLOOR, WALL, WALL]), np.array([0.0, 0.48, 0.40]))
NEARLY = (np.array([FLOOR, WALL, [np.cos(0.1), np.sin(0.1), 0.0]]), np.array([0.0, 0.48, 0.40]))


@pytest.mark.parametrize(("make", "status", "words"), [
    (lambda: in_cell(target_planes=PARALLEL), UNDETERMINED, ["wall_x and wall_y", "parallel", "third"]),
    (lambda: in_cell(target_planes=NEARLY), UNDETERMINED, ["wall_x and wall_y", "degrees from parallel"]),
    (lambda: in_cell(target_planes=PARALLEL, nominal_pose=False), UNDETERMINED, ["parallel"]),
    (declared_parallel, INPUT_AT_FAULT, ["dataset.yaml", "planes.wall_y.normal", "correct the normal"]),
    (swapped_names, INPUT_AT_FAULT, ["'wall_x'", "'wall_y'", "exchanged in poses.csv"]),
    (line_on_a_wall, UNDETERMINED, ["plane 'wall_y'", "lie on a line"]),
    (contacts_on_a_line, UNDETERMINED, ["plane 'wall_y'", "lie on a line"]),
    (lambda: in_cell(poses_per_plane=5), UNDETERMINED, ["30 equations for 32 unknowns", "1 more"]),
    (lambda: in_cell(poses_per_plane=1), UNDETERMINED, ["3 poses give 6 equations", "more"]),
    (lambda: in_cell(poses_per_plane=1, nominal_pose=False), UNDETERMINED, ["3 poses give 6 equations"]),
    (lambda: in_cell(kind="probe", poses_per_plane=3), UNDETERMINED, ["9 poses give 9 equations", "more"]),
    (lambda: only(in_cell(kind="tracker"), np.arange(1)), UNDETERMINED, ["1 pose gives 3 equations", "more"]),
    (lambda: only(in_cell(kind="tracker"), np.arange(4)), UNDETERMINED, ["4 poses give 12 equations"]),
])  # fmt: skip
def test_what_cannot_be_determined_is_refused(make, status, words, tmp_path):
    """Well-formed datasets that no calibrator could use: status, and words that say what to do."""
    make().write(tmp_path / "dataset")
    assert run("validate", tmp_path / "dataset").exit_code == 0
    result = run("calibrate", tmp_path / "dataset", "-o", tmp_path / "out")
    refused(result, status, *words, output=tmp_path / "out")


def test_fewer_than_three_planes_are_refused(tmp_path):
    """Two planes in dataset.yaml, or three of which one was never measured: refused before any fit."""
    scene = in_cell()
    two = only(scene, scene.dataset.plane_index != 2)
    mapping = two.mapping()
    for case, planes in (("measured", mapping["planes"]), ("declared", mapping["planes"][:2])):
        write_dataset(tmp_path / case, mapping={**mapping, "planes": planes}, **two.tables())
        result = run("calibrate", tmp_path / case, "-o", tmp_path / "out")
        refused(result, INPUT_AT_FAULT, "three", output=tmp_path / "out")


# --- what is wrong in the files themselves ---


def drop_scan(folder: Path) -> None:
    """Take all points of pose 7 away."""
    edit_lines(folder, "scans.csv", lambda lines: [line for line in lines if not line.startswith("7,")])


def scale_column(folder: Path, file: str, columns: list[str], factor: float) -> None:
    """Multiply columns of a table."""
    table = pd.read_csv(folder / file)
    table[columns] = table[columns] * factor
    table.to_csv(folder / file, index=False)


def replace_text(folder: Path, file: str, old: str, new: str) -> None:
    """Replace the first occurrence of a text."""
    text = (folder / file).read_text(encoding="utf-8")
    assert old in text
    (folder / file).write_text(text.replace(old, new, 1), encoding="utf-8")


JOINTS = joint_names(6)


@pytest.mark.parametrize(("spoil", "words"), [
    (drop_scan, ["poses.csv, row 8, column pose", "pose 7 has no laser point"]),
    (lambda f: edit_cell(f, "poses.csv", 5, "q3", "abc"), ["poses.csv, row 5, column q3", "not a number"]),
    (lambda f: edit_cell(f, "poses.csv", 5, "q3", "nan"), ["poses.csv, row 5, column q3"]),
    (lambda f: edit_cell(f, "poses.csv", 5, "q3", ""), ["poses.csv, row 5, column q3"]),
    (lambda f: edit_cell(f, "scans.csv", 9, "z", "inf"), ["scans.csv, row 9, column z"]),
    (lambda f: edit_cell(f, "poses.csv", 4, "pose", "2"), ["poses.csv, row 4, column pose", "row 3"]),
    (lambda f: edit_cell(f, "scans.csv", 4, "pose", "999"), ["scans.csv, row 4", "unknown pose 999"]),
    (lambda f: edit_cell(f, "poses.csv", 3, "plane", "flor"), ["row 3, column plane", "flor", "floor"]),
    (lambda f: edit_cell(f, "poses.csv", 1, "q2", "joint2"), ["poses.csv", "q2"]),
    (lambda f: scale_column(f, "poses.csv", JOINTS, 180 / np.pi), ["poses.csv", "degrees"]),
    (lambda f: scale_column(f, "scans.csv", ["x", "z"], 1e3), ["scans.csv", "millimetres"]),
    (lambda f: replace_text(f, "dataset.yaml", "name:", "nam:"), ["dataset.yaml", "nam"]),
    (lambda f: replace_text(f, "dataset.yaml", "name:", "x: !!python/none\nname:"), ["dataset.yaml"]),
    (lambda f: (f / "scans.csv").unlink(), ["scans"]),
    (lambda f: (f / "dataset.yaml").unlink(), ["dataset.yaml"]),
    (shutil.rmtree, ["dataset"]),
])  # fmt: skip
def test_faults_in_the_files_are_refused(spoil, words, dataset, tmp_path):
    """File, row and column on stderr, exit status 2 from ``validate`` and ``calibrate`` alike, no
    output folder.
    """
    spoil(dataset)
    for command in (["validate", dataset], ["calibrate", dataset, "-o", tmp_path / "out"]):
        refused(run(*command), INPUT_AT_FAULT, *words, output=tmp_path / "out")


def test_an_old_result_survives_a_failed_run(sound, dataset, tmp_path):
    """A refused calibration leaves an earlier calibration.json as it was."""
    out = Path(shutil.copytree(sound / "out", tmp_path / "out"))
    drop_scan(dataset)
    refused(run("calibrate", dataset, "-o", out), INPUT_AT_FAULT)
    assert [path.name for path in out.iterdir()] == ["calibration.json"]
    assert (out / "calibration.json").read_bytes() == (sound / "out/calibration.json").read_bytes()


@pytest.mark.parametrize(("options", "words"), [
    (["--hold", "a_9"], ["--hold", "a_9"]),
    (["--effects", "no_such_effect"], ["--effects", "no_such_effect"]),
    (["--effects-from", "missing.json"], ["missing.json"]),
])  # fmt: skip
def test_options_that_name_nothing_are_refused(options, words, sound, tmp_path):
    """Unknown parameters, effects and files: exit status 2 and the name."""
    result = run("calibrate", sound / "dataset", "-o", tmp_path / "out", *options)
    refused(result, INPUT_AT_FAULT, *words, output=tmp_path / "out")


# --- predict and evaluate ---


@pytest.mark.parametrize(("spoil", "words"), [
    (lambda t: t.drop(columns="q3"), ["joints.csv", "q3", "missing"]),
    (lambda t: t.drop(columns=["q3", "pose"]), ["q3", "pose"]),
    (lambda t: t.assign(q7=0.0), ["joints.csv", "q7"]),
    (lambda t: t.assign(q2=[0.1, np.nan, 0.1, 0.1, 0.1]), ["joints.csv, row 3, column q2"]),
    (lambda t: t.assign(q2=["0.1", "0.1", "north", "0.1", "0.1"]), ["joints.csv, row 4, column q2", "north"]),
    (lambda t: t.assign(q2=np.inf), ["joints.csv, row 2, column q2"]),
    (lambda t: t.assign(**{name: t[name] * 100 for name in JOINTS}), ["joints.csv", "degrees"]),
    (lambda t: t.assign(pose=1), ["joints.csv", "pose"]),
])  # fmt: skip
def test_predict_refuses_joints_it_cannot_read(spoil, words, sound, tmp_path):
    """Missing columns, too many joints, NaN, text, infinity, degrees, one id twice: named, and no file
    written.
    """
    spoil(pd.read_csv(sound / "joints.csv")).to_csv(tmp_path / "joints.csv", index=False, na_rep="nan")
    result = run(
        "predict", sound / "out/calibration.json", tmp_path / "joints.csv", "-o", tmp_path / "frames.csv"
    )
    refused(result, INPUT_AT_FAULT, *words, output=tmp_path / "frames.csv")


def test_predict_refuses_what_is_no_table_or_no_calibration(sound, tmp_path):
    """No such file, a folder, an empty file, a calibration that is none."""
    (tmp_path / "empty.csv").touch()
    calibration, joints, out = sound / "out/calibration.json", sound / "joints.csv", tmp_path / "f.csv"
    for bad in (tmp_path / "missing.csv", tmp_path, tmp_path / "empty.csv"):
        refused(run("predict", calibration, bad, "-o", out), INPUT_AT_FAULT, output=out)
    for bad in (tmp_path / "missing.json", tmp_path, sound / "joints.csv", sound / "truth/truth.json"):
        refused(run("predict", bad, joints, "-o", out), INPUT_AT_FAULT, output=out, lines=1)


def test_a_column_that_an_effect_needs_is_named(sound, tmp_path):
    """A calibration with drift over time predicts only where the time is given: exit status 2, naming
    the column.
    """
    dataset = tmp_path / "dataset"
    shutil.copytree(sound / "dataset", dataset)
    poses = pd.read_csv(dataset / "poses.csv")
    poses.assign(time=10.0 * np.arange(len(poses))).to_csv(dataset / "poses.csv", index=False)
    result = run("calibrate", dataset, "-o", tmp_path / "out", "--effects", "thermal_drift")
    assert result.exit_code == 0, result.output
    calibration = tmp_path / "out/calibration.json"
    result = run("predict", calibration, sound / "joints.csv", "-o", tmp_path / "f.csv")
    refused(result, INPUT_AT_FAULT, "time", "missing", output=tmp_path / "f.csv")
    pd.read_csv(sound / "joints.csv").assign(time=0.0).to_csv(tmp_path / "joints.csv", index=False)
    assert run("predict", calibration, tmp_path / "joints.csv", "-o", tmp_path / "f.csv").exit_code == 0


def test_an_output_that_cannot_be_written_is_said(sound, tmp_path):
    """A folder in the place of the file, a file in the place of the folder: exit status 2, one line,
    nothing changed.
    """
    (tmp_path / "taken").write_text("mine", encoding="utf-8")
    calibration, joints = sound / "out/calibration.json", sound / "joints.csv"
    refused(run("predict", calibration, joints, "-o", tmp_path), INPUT_AT_FAULT, "cannot be written", lines=1)
    below = tmp_path / "taken" / "frames.csv"
    refused(run("predict", calibration, joints, "-o", below), INPUT_AT_FAULT, "cannot be written", lines=1)
    for command in (["calibrate", sound / "dataset"], ["evaluate", calibration, sound / "truth"]):
        refused(run(*command, "-o", tmp_path / "taken"), INPUT_AT_FAULT, "cannot be written", lines=1)
    assert (tmp_path / "taken").read_text(encoding="utf-8") == "mine"
    assert [path.name for path in tmp_path.iterdir()] == ["taken"]


def test_evaluate_refuses_a_truth_that_is_none(sound, tmp_path):
    """No folder, no poses, damaged JSON, fewer joints: named, and no output."""
    calibration, out = sound / "out/calibration.json", tmp_path / "e"
    refused(
        run("evaluate", calibration, tmp_path / "no", "-o", out),
        INPUT_AT_FAULT,
        "truth_poses.csv",
        output=out,
    )
    truth = Path(shutil.copytree(sound / "truth", tmp_path / "truth"))
    (truth / "truth.json").write_text("{", encoding="utf-8")
    refused(run("evaluate", calibration, truth, "-o", out), INPUT_AT_FAULT, "truth.json", output=out)
    (truth / "truth.json").write_text('{"parameters": 3, "planes": "x"}', encoding="utf-8")
    refused(run("evaluate", calibration, truth, "-o", out), INPUT_AT_FAULT, "truth.json", output=out)
    (truth / "truth.json").unlink()
    assert run("evaluate", calibration, truth, "-o", tmp_path / "fine").exit_code == 0
    pd.read_csv(truth / "truth_poses.csv").drop(columns=["q6", "rz"]).to_csv(
        truth / "truth_poses.csv", index=False
    )
    refused(run("evaluate", calibration, truth, "-o", out), INPUT_AT_FAULT, "q6", "rz", output=out)
