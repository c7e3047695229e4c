"""A set-up that contradicts the data is named, and one that does not is left in peace."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner

from scalar.cli import cli
from scalar.data.dataset import Dataset
from scalar.data.declared import Sensor
from scalar.data.io.plain_yaml import dump_yaml, load_yaml
from scalar.diagnosis import diagnose
from scalar.errors import InvalidInput, Undetermined
from scalar.estimation.calibrate import calibrate
from scalar.estimation.setup.alternatives import alternatives
from scalar.estimation.setup.arm.several_signs import all_signs, several_signs
from scalar.estimation.setup.suspicion import WrongSetup
from scalar.geometry.robot import Robot
from scalar.robots import read_arm
from scalar.units import DEG, MM
from tests.random_scene import make_scene


@pytest.fixture(scope="module")
def sound() -> Dataset:
    """Return a sound dataset of ninety scans."""
    return make_scene("vs060", poses_per_plane=30, points_per_scan=12, noise=1e-4, seed=5).dataset


def with_columns(dataset: Dataset, **columns: np.ndarray) -> Dataset:
    return replace(dataset, poses=dataset.poses.assign(**columns))


def spoiled(dataset: Dataset, what: str) -> Dataset:
    """Return the dataset with one thing about its set-up wrong, made independently of the alternatives that are tried."""
    q, N = dataset.q, dataset.n_poses
    if what == "joint_sign":
        return with_columns(dataset, q4=-q[:, 3])
    if what == "joint_zero":
        return with_columns(dataset, q3=q[:, 2] + 100 * DEG)
    if what == "swapped_joints":
        return with_columns(dataset, q2=q[:, 2], q3=q[:, 1])
    if what == "swapped_planes":
        swap = {"floor": "wall_x", "wall_x": "floor"}
        return with_columns(
            dataset, plane=np.array([swap.get(p, p) for p in dataset.poses["plane"]], dtype=object)
        )
    if what == "shifted_poses":
        later = np.r_[1:N, 0]
        return with_columns(dataset, **{f"q{j + 1}": q[later, j] for j in range(6)}).subset(np.arange(N - 1))
    if what == "reversed_poses":
        return with_columns(dataset, **{f"q{j + 1}": q[N - 1 - np.arange(N), j] for j in range(6)})
    if what == "length_unit":
        return replace(dataset, points=dataset.points / 25.4)
    if what == "angle_unit":
        return with_columns(dataset, **{f"q{j + 1}": q[:, j] * 0.9 for j in range(6)})
    assert what == "convention"
    mapping = dataset.robot.to_mapping()
    for joint in mapping["joints"]:
        joint.pop("beta")
    return replace(dataset, robot=Robot.from_mapping({**mapping, "convention": "standard-dh"}))


WRONG = {
    "joint_sign": "joint 4",
    "joint_zero": "joint 3",
    "swapped_joints": "joints 2 and 3",
    "swapped_planes": "planes floor and wall_x",
    "shifted_poses": "poses.csv",
    "reversed_poses": "poses.csv",
    "angle_unit": "poses.csv",
    "convention": "robot.convention",
}


@pytest.mark.slow
@pytest.mark.parametrize(("what", "where"), WRONG.items())
def test_a_wrong_setup_is_named_with_the_residual_before_and_after(sound, what, where):
    """A single wrong thing is named first, with a residual below a millimetre when it is corrected, and nothing is calibrated."""
    try:
        suspicions = calibrate(spoiled(sound, what)).summary["setup"]
    except WrongSetup as refusal:
        suspicions = [{**s.to_mapping(), "sentence": s.sentence} for s in refusal.suspicions]
        assert suspicions[0]["rms_after_mm"] < 1.0 < suspicions[0]["rms_before_mm"]
    assert (suspicions[0]["what"], suspicions[0]["where"]) == (what, where)


@pytest.fixture(scope="module")
def tracked() -> Dataset:
    """Return a sound dataset of seventy-five poses before a tracker."""
    return make_scene("vs060", "tracker", poses_per_plane=25, noise=1e-4, seed=7).dataset


@pytest.mark.parametrize("joint", [2, *(pytest.param(joint, marks=pytest.mark.slow) for joint in (3, 4, 5))])
@pytest.mark.parametrize("degrees", [90, 180])
def test_a_zero_wrong_by_a_quarter_or_half_turn_is_named_for_a_tracker(tracked, joint, degrees):
    """The fit follows such a zero and leaves no residual, and yet no other parameter and no pose is blamed for it."""
    moved = with_columns(tracked, **{f"q{joint}": tracked.q[:, joint - 1] + degrees * DEG})
    with pytest.raises(WrongSetup) as refused:
        calibrate(moved)
    named = {(s.what, s.where) for s in refused.value.suspicions}
    assert ("joint_zero", f"joint {joint}") in named
    if abs(degrees) == 90:
        (suspicion,) = refused.value.suspicions
        stated = float(re.search(r"is off by (\S+) degrees", suspicion.sentence)[1])
        assert stated == pytest.approx(-degrees, abs=2.0)
        assert suspicion.rms_after < 1 * MM < 100 * MM < suspicion.rms_before


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["tracker", "line-laser"])
@pytest.mark.parametrize("joints", [(1, 2), (2, 5), (4, 5)])
def test_two_wrong_signs_are_named_together(sound, tracked, kind, joints):
    """If two joints count the other way, both are named in one sentence, first or among several that explain the data alike."""
    dataset = tracked if kind == "tracker" else sound
    spoilt = with_columns(dataset, **{f"q{j}": -dataset.q[:, j - 1] for j in joints})
    with pytest.raises(WrongSetup) as refused:
        calibrate(spoilt)
    named = [s.where for s in refused.value.suspicions]
    assert f"joints {joints[0]} and {joints[1]}" in named
    assert len(named) == 1 or all(
        "which these data do not distinguish" in s.sentence for s in refused.value.suspicions
    )


def test_signs_that_an_import_changed_are_changed_in_its_mapping(tracked):
    """The remedy of two wrong signs names the mapping, which may have made them wrong, beside the table of joints."""
    remedy = next(iter(several_signs(tracked, 2))).remedy
    assert "dataset.yaml" in remedy and "signs of these joints in the mapping" in remedy


@pytest.mark.slow
def test_three_wrong_signs_are_named_together(tracked):
    """If three joints count the other way, as with some controllers, all are named together."""
    spoilt = with_columns(tracked, **{f"q{j}": -tracked.q[:, j - 1] for j in (1, 3, 5)})
    with pytest.raises(WrongSetup) as refused:
        calibrate(spoilt)
    assert "joints 1, 3 and 5" in [s.where for s in refused.value.suspicions]


def test_signs_of_all_joints_are_one_reading(tracked):
    """If the controller counts all axes clockwise, the reading is the same arm at the angles counted back; three moving joints are none."""
    spoilt = with_columns(tracked, **{f"q{j}": -tracked.q[:, j - 1] for j in range(1, 7)})
    (reading,) = all_signs(spoilt)
    assert reading.where == "all joints" and reading.corrects_robot
    np.testing.assert_allclose(
        reading.dataset.robot.flange(spoilt.q), tracked.robot.flange(tracked.q), atol=1e-12
    )
    still = with_columns(tracked, **{f"q{j}": np.zeros(tracked.n_poses) for j in (1, 2, 3)})
    assert list(all_signs(still)) == []


def test_a_zero_that_needs_another_length_gives_way_to_signs_that_need_none():
    """On an arm whose axis 4 lies above its forearm, three wrong signs are nearly a zero of joint 3 and a longer a_4; the signs explain more."""
    rng = np.random.default_rng(1)
    robot = read_arm("abb_irb1200_5_90").robot
    q = rng.uniform(-1.0, 1.0, (60, 6)) * [2.5, 1.2, 1.0, 2.5, 1.6, 2.5]
    T_flange_target = np.eye(4)
    T_flange_target[:3, 3] = 0.02, -0.01, 0.09
    points = (robot.flange(q) @ T_flange_target)[:, :3, 3] + rng.normal(0.0, 2e-5, (60, 3))
    counted_back = q * [1, -1, -1, 1, -1, 1]
    sensor = Sensor("tracker", T_flange_target, 2e-5)
    dataset = Dataset.from_arrays(robot=robot, sensor=sensor, q=counted_back, points=points)
    with pytest.raises(WrongSetup) as refused:
        calibrate(dataset)
    assert [s.where for s in refused.value.suspicions] == ["joints 2, 3 and 5"]


@pytest.mark.parametrize(
    ("what", "file"),
    [("swapped_joints", "poses.csv"), ("swapped_planes", "poses.csv"), ("joint_sign", "dataset.yaml")],
)
def test_a_message_begins_with_the_file_that_has_to_be_corrected(sound, what, file):
    """An error in a table is not looked for in the description, and the other way round."""
    with pytest.raises(WrongSetup) as refused:
        calibrate(spoiled(sound, what))
    assert {fault.file for fault in refused.value.faults} == {file}


@pytest.mark.slow
def test_a_refusal_that_need_not_be_explained_is_a_refusal(sound):
    """Whether a dataset is refused does not depend on whether the cause is looked for; the sentence that names it does."""
    for explain, named in ((True, True), (False, False)):
        with pytest.raises((InvalidInput, Undetermined)) as refused:
            calibrate(spoiled(sound, "joint_sign"), explain=explain)
        assert isinstance(refused.value, WrongSetup) == named


def test_lengths_in_another_unit_are_not_passed_in_silence(sound):
    """Scans in inches that are taken for millimetres shrink the arm without a residual, and the fit says that all links came out short."""
    try:
        suspicions = calibrate(spoiled(sound, "length_unit")).summary["setup"]
        what = [s["what"] for s in suspicions]
    except WrongSetup as refusal:
        what = [s.what for s in refusal.suspicions]
    assert "length_unit" in what


def test_a_mirrored_scan_is_a_sensor_turned_from_its_stated_place(sound):
    """An x that counts the other way is a half turn about z, which the stated pose shows though no residual does."""
    dataset = replace(
        sound,
        points=sound.points * np.array([-1.0, 1.0]),
        sensor=replace(sound.sensor, T_flange_sensor=calibrate(sound).model.T_flange_sensor),
    )
    (suspicion,) = calibrate(dataset).summary["setup"]
    assert suspicion["what"] == "sensor_pose"
    assert "the scanner sits turned by 180 degrees" in suspicion["sentence"]


@pytest.mark.parametrize("robot", ["vs060", "ur10e", "panda", "puma560"])
def test_a_sound_setup_is_left_in_peace(robot):
    """With natural errors of an arm, rough planes and a rough sensor pose, nothing is suspected."""
    scene = make_scene(
        robot, poses_per_plane=40, points_per_scan=10, noise=1e-4, length_error=2 * MM, angle_error=1 * DEG
    )
    assert calibrate(scene.dataset).summary["setup"] == []


@pytest.mark.slow
def test_a_diagnosis_refuses_what_a_calibration_refuses(sound):
    """A diagnosis names the same joint as a calibration, and does not fail otherwise."""
    with pytest.raises(InvalidInput, match="joint 4 counts the other way"):
        diagnose(spoiled(sound, "joint_sign"))


@pytest.mark.slow
def test_a_diagnosis_names_a_zero_that_its_fit_follows(tracked):
    """A tracker's fit leaves nothing of a zero that is a quarter turn off: the diagnosis names the zero all the same."""
    with pytest.raises(WrongSetup, match="the zero of joint 3 is off by -90"):
        diagnose(with_columns(tracked, q3=tracked.q[:, 2] + 90 * DEG))


def test_alternatives_differ_from_what_is_stated(sound):
    """Each alternative changes the robot, the angles, the labels or the points, and none repeats another."""
    seen = []
    for alternative in alternatives(sound):
        d = alternative.dataset
        key = (
            d.robot.geometry.tobytes(),
            d.robot.T_n_flange.tobytes(),
            d.q.tobytes(),
            d.points.tobytes(),
            tuple(d.poses["plane"]),
        )
        seen.append(key)
    assert len(set(seen)) == len(seen)


@pytest.mark.slow
@pytest.mark.parametrize("convention", ["modified-dh", "standard-dh"])
def test_the_corrected_table_is_offered_and_works(tmp_path, convention):
    """`corrected-dataset.yaml` in the place of dataset.yaml can be calibrated, and its table has the user's convention."""
    scene = make_scene("vs060", poses_per_plane=30, points_per_scan=12, noise=1e-4, seed=6)
    folder = scene.write(tmp_path / "cell")
    if convention == "standard-dh":
        mapping = load_yaml(folder / "dataset.yaml")
        dump_yaml({**mapping, "robot": in_standard_dh(mapping["robot"])}, folder / "dataset.yaml")
    poses = pd.read_csv(folder / "poses.csv")
    poses.assign(q4=-poses["q4"]).to_csv(folder / "poses.csv", index=False)
    run = CliRunner().invoke(cli, ["calibrate", str(folder), "-o", str(tmp_path / "out")])
    assert run.exit_code == 2
    assert "joint 4 counts the other way" in run.output
    corrected = tmp_path / "out" / "corrected-dataset.yaml"
    was, now = (load_yaml(path)["robot"] for path in (folder / "dataset.yaml", corrected))
    assert now["convention"] == convention
    changed = [i for i, (old, new) in enumerate(zip(was["joints"], now["joints"], strict=True)) if old != new]
    assert changed == ([3, 4] if convention == "modified-dh" else [2, 3])
    assert {key: now[key] for key in was if key != "joints"} == {
        k: v for k, v in was.items() if k != "joints"
    }
    assert not any(0 < abs(new[key]) < 1e-9 for new in now["joints"] for key in ("a", "alpha", "d", "theta"))
    (folder / "dataset.yaml").write_bytes(corrected.read_bytes())
    run = CliRunner().invoke(cli, ["calibrate", str(folder), "-o", str(tmp_path / "out")])
    assert run.exit_code == 0, run.output


def in_standard_dh(mapping: dict) -> dict:
    """Return a ``robot:`` block of modified DH, whose first row has no a and alpha, as one of standard DH."""
    joints = mapping["joints"]
    after = [*joints[1:], {"a": 0.0, "alpha": 0.0}]
    rows = [
        {key: joint[key] for key in ("d", "theta", "limits")} | {key: follows[key] for key in ("a", "alpha")}
        for joint, follows in zip(joints, after, strict=True)
    ]
    return {**mapping, "convention": "standard-dh", "joints": rows}
