"""What ``scalar validate`` warns of although it is no fault, and what of it a calibration refuses."""

from dataclasses import replace

import numpy as np
import pytest

from scalar import calibrate, diagnose
from scalar.errors import InvalidInput, Undetermined
from tests.cli.running import run
from tests.random_scene import make_scene


@pytest.fixture(scope="module")
def scene():
    """Return a workcell with a tracker."""
    return make_scene("vs060", "tracker", seed=2, poses_per_plane=20)


def told(scene, folder, **changes):
    """Return what `validate` prints of the scene's dataset with other columns of poses.csv, after checking that it finds no fault."""
    dataset = replace(scene.dataset, poses=scene.dataset.poses.assign(**changes))
    replace(scene, dataset=dataset).write(folder / "cell")
    result = run("validate", folder / "cell")
    assert result.exit_code == 0, result.output
    assert ("see the warnings" in result.output) == ("warning:" in result.output)
    return [line for line in result.output.splitlines() if "warning:" in line or "note:" in line]


def test_nothing_is_said_of_sound_data(scene, tmp_path):
    """Within the limits, with all joints in motion, there is no warning and no note."""
    assert told(scene, tmp_path) == []


def test_a_joint_beyond_its_limits_is_named(scene, tmp_path):
    """Joint, number of poses and largest excess are said; where a turn less lies within the limits, the turn is suspected."""
    robot, q = scene.dataset.robot, scene.dataset.poses["q2"].to_numpy()
    high = robot.limits[1, 1]
    over = q.copy()
    over[[3, 7]] = high + np.deg2rad([2.0, 5.0])
    (line,) = told(scene, tmp_path / "over", q2=over)
    worst = scene.dataset.pose_ids[7]
    assert "warning: joint 2 " in line and "in 2 of 60 poses, by at most 5.0 deg" in line
    assert f"(pose {worst})" in line and "zero of this joint" in line
    turned = q.copy()
    turned[5] += 2.0 * np.pi
    (line,) = told(scene, tmp_path / "turned", q2=turned)
    assert "in 1 of 60 poses" in line and "whole turn" in line


def test_a_joint_that_counts_the_other_way_is_asked_about(scene, tmp_path):
    """If the positions lie within the limits with the other sign, and beyond them as recorded, the sign is named first."""
    low, high = scene.dataset.robot.limits[2]
    assert abs(low + high) > 0.2, "the limits have to tell the signs apart"
    q = np.linspace(low + 0.01, high - 0.01, scene.dataset.n_poses)
    (line,) = told(scene, tmp_path / "sign", q3=-q)
    assert "joint 3 is beyond its limits" in line and "check whether this joint counts the other way" in line
    assert told(scene, tmp_path / "right", q3=q) == []


def test_limits_of_converted_joints_are_said_to_be_those_of_the_dataset(scene, tmp_path):
    """After an import that converted joints, the angle beyond its limit is not the one that the controller shows."""
    over = scene.dataset.poses["q2"].to_numpy().copy()
    over[3] = scene.dataset.robot.limits[1, 1] + np.deg2rad(2.0)
    imported = {"joints": "q2 = -J2", "mapping": "a.yaml"}
    poses = scene.dataset.poses.assign(q2=over)
    replace(scene.dataset, poses=poses, imported=imported).write(tmp_path / "cell")
    said = run("validate", tmp_path / "cell").output
    assert "joint 2 is beyond its limits" in said and "those of the controller (q2 = -J2)" in said


def test_a_payload_in_grams_is_suspected(scene, tmp_path):
    """Two and a half tons are more than arms carry; as many kilograms are no reason to warn."""
    (line,) = told(scene, tmp_path / "grams", payload=2500.0)
    assert "payload" in line and "grams" in line and "2500 kg" in line
    assert told(scene, tmp_path / "kilograms", payload=2.5) == []


def test_a_joint_that_never_moves_is_said_and_calibrated(scene, tmp_path):
    """Campaigns may leave a joint alone: it is a note, and the calibration is not refused because of it."""
    still = make_scene("vs060", "tracker", seed=2, poses_per_plane=20, still_joint=6)
    (line,) = told(still, tmp_path)
    assert "note: joint 6 has the same position in all poses" in line
    try:
        calibrate(still.dataset)
    except Undetermined as error:  # these poses may leave parameters of joint 6 open
        assert "not the robot" not in str(error)


def test_a_refused_set_up_names_the_joint_whose_angle_was_not_recorded(scene):
    """If a column holds one number although the joint moved, no fit explains the points, and the refusal names the joint."""
    dataset = replace(scene.dataset, poses=scene.dataset.poses.assign(q2=0.3))
    with pytest.raises((InvalidInput, Undetermined), match="joint 2 has the same position in all poses"):
        calibrate(dataset)


@pytest.mark.parametrize("what", ["poses", "points"])
def test_data_in_which_nothing_moves_are_refused_for_that_reason(what, scene, tmp_path):
    """Equal poses, or equal points, are warned of by `validate` and refused by `calibrate` and `diagnose`, which do not blame the robot."""
    dataset = scene.dataset
    if what == "poses":
        first = {f"q{i}": dataset.poses[f"q{i}"].iloc[0] for i in range(1, 7)}
        dataset = replace(dataset, poses=dataset.poses.assign(**first))
    else:
        dataset = replace(dataset, points=np.repeat(dataset.points[:1], len(dataset.points), axis=0))
    (line,) = told(replace(scene, dataset=dataset), tmp_path)
    assert f"warning: {what}.csv: " in line and "refuses" in line
    for estimate in (calibrate, diagnose):
        with pytest.raises(InvalidInput, match=f"{what}.csv: .*determine nothing"):
            estimate(dataset)
    result = run("calibrate", tmp_path / "cell", "-o", tmp_path / "out")
    assert result.exit_code == 2 and not (tmp_path / "out").exists()
