"""On which side of its play a joint rests: from the order of the poses, or from the recorded directions of approach; and how its size is shown."""

import re
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from scalar.cli.calibration_words import describe_calibration
from scalar.cli.diagnosis_words import _sizes
from scalar.cli.pose_lines import lines_on_moves
from scalar.data.poses import Poses
from scalar.effects.joint_backlash import JointBacklash
from scalar.effects.joint_hysteresis import JointHysteresis
from scalar.estimation.calibrate import calibrate
from scalar.estimation.result import Calibration
from scalar.geometry.robot import Robot
from tests.random_scene import make_scene
from tests.robot_configs import robot_mapping
from tests.turning import turning

Q = np.zeros((4, 6))
Q[:, 1] = [0.1, 0.4, 0.2, 0.3]  # joint 2 comes from below, from above, from below
SIDES = [1.0, -1.0, 1.0]


def sides(columns) -> np.ndarray:
    """Return the sides ``(4,)`` on which joint 2 is said to rest, for play that was found from the order of the poses."""
    robot = Robot.from_mapping(robot_mapping("vs060"))
    return JointBacklash(2, "moves").joint_basis(robot, Poses.from_arrays(Q, columns, turning(6)))[:, 1, 0]


@pytest.mark.parametrize(
    "columns",
    [
        {"order": np.arange(4.0)},
        {"approach2": np.array([0.0, *SIDES])},
        {"order": np.array([3.0, 1.0, 2.0, 0.0]), "approach2": np.array([0.0, *SIDES])},
    ],
)
def test_play_found_from_the_order_is_predicted_from_the_order_or_the_approach(columns):
    """Predictions use the directions of approach if they are given, which say more than an order that assumes direct moves, else the order."""
    np.testing.assert_array_equal(sides(columns)[1:], SIDES)


def test_one_order_for_all_poses_says_nothing_on_moves():
    """It is the state at the end of a campaign, say, and no sequence; directions of approach that are given count."""
    assert not sides({"order": 50.0}).any()
    assert list(sides({"order": 50.0, "approach2": np.array([1.0, *SIDES])})) == [1.0, *SIDES]


def test_without_order_and_approach_the_play_is_left_out():
    """The middle of the play is the best guess if nothing is known of the move."""
    assert not sides({}).any()


@pytest.mark.parametrize(
    ("effect", "needed"),
    [
        (JointBacklash(2, "moves", coefficients=np.array([1e-3])), "order or approach2"),
        (JointHysteresis(2, (0.05,)), "order"),
    ],
)
def test_a_table_without_moves_is_told_what_is_left_out(effect, needed):
    """The line names the effect and the columns that would tell; with any of them, and for play by the torque, there is none.

    What the play moves is a thousandth of the distance of the sensor from the axis of joint 2.
    """
    calibration = Calibration.nominal(make_scene(seed=2, poses_per_plane=8).dataset)
    calibration = replace(calibration, model=replace(calibration.model, effects=(effect,)))
    table = pd.DataFrame(Q, columns=[f"q{i + 1}" for i in range(6)])
    (line,) = lines_on_moves(calibration, table)
    assert effect.title in line and line.endswith(needed)
    if isinstance(effect, JointBacklash):
        places, shoulder = calibration.predict(Q)[:, :3, 3], calibration.model.robot.frames(Q)[:, 2]
        from_axis = np.linalg.norm(np.cross(places - shoulder[:, :3, 3], shoulder[:, :3, 2]), axis=1).max()
        stated = float(re.search(r"up to ([\d.]+) mm to either side", line)[1])
        assert stated == pytest.approx(from_axis, rel=0.01)  # a thousandth of it, in mm
        others = table.assign(q=1.0, target=2, note=[1.0, np.nan, 2.0, 3.0])  # columns that no effect needs
        assert lines_on_moves(calibration, others) == [line]
        wanted = pd.concat([others, pd.DataFrame({"note": [1.0]})])  # a row without joint angles
        assert lines_on_moves(calibration, wanted) == [line]
        (without_joints,) = lines_on_moves(calibration, pd.DataFrame({"x": [0.1]}))
        assert "to either side" not in without_joints
    assert not lines_on_moves(calibration, pd.DataFrame({"order": [1]}))
    by_torque = replace(calibration, model=replace(calibration.model, effects=(JointBacklash(2, "torque"),)))
    assert not lines_on_moves(by_torque, pd.DataFrame({"q2": [0.1]}))


def test_play_by_the_torque_is_looked_for_beside_recorded_directions():
    """A load may hold a joint on one side of its play from whichever side it came, as where the bolts of a link are loose."""
    dataset = make_scene(kind="tracker", seed=2, poses_per_plane=8).dataset
    rng = np.random.default_rng(1)
    approaches = {f"approach{j}": rng.choice([-1.0, 1.0], dataset.n_poses) for j in range(1, 7)}
    found = JointBacklash.candidates(replace(dataset, poses=dataset.poses.assign(**approaches)))
    assert {e.by for e in found if e.erring_joint == 3} == {"approach", "torque"}
    assert "moves" not in {e.by for e in found}


@pytest.mark.parametrize("b", [-2e-4, 2e-4])
@pytest.mark.parametrize(
    "effect", [JointBacklash(2, "moves"), JointBacklash(2, "torque"), JointHysteresis(2, (0.05, 0.2))]
)
def test_a_half_width_is_shown_by_its_size(effect, b):
    """A table shows half a width without a sign, and says on which side of its reading the joint stands, after which moves or torques."""
    effect = effect.with_coefficients(np.full(len(effect.coefficients), b))
    _, rows = effect.table([1e-5] * len(effect.coefficients))
    assert [row[1] for row in rows] == ["0.01146"] * len(effect.coefficients)
    assert effect.sign_in_words in rows[0][0]
    assert ("beyond its reading" in rows[0][0]) == (b > 0)
    if effect.name == "joint_hysteresis" or effect.by == "moves":
        # The arm stands at q + dq: after a move to larger q, where s = 1, that is beyond q if dq > 0.
        error = effect.joint_basis(Robot.from_mapping(robot_mapping("vs060")), moved()) @ effect.coefficients
        assert (error[-1, 1] > 0) == ("stands beyond" in rows[0][0])


def test_wind_ups_that_differ_in_sign_are_shown_with_it():
    """A small wind-up against a larger one is no size, so that both keep their signs."""
    effect = JointHysteresis(2, (0.05, 0.2)).with_coefficients(np.array([-1e-4, 3e-4]))
    assert [row[1][0] for row in effect.table([None, None])[1]] == ["−", "0"]


def test_the_terminal_shows_the_size_of_play_and_what_its_sign_meant():
    """So do `calibrate` and `diagnose`: the number without its sign, then the words."""
    entry = {"coefficients": {"half_width_rad": {"value": -2e-4, "std": 1e-5}}}
    effect = JointBacklash(2, "moves").with_coefficients(np.array([-2e-4]))
    assert _sizes(entry, effect.sign_in_words).startswith(": half width 0.01146 ± 0.00057")
    assert "stays behind its reading" in _sizes(entry, effect.sign_in_words)
    calibration = calibrate(
        make_scene("vs060", "tracker", poses_per_plane=20, seed=3).dataset, fixed_effects=[effect]
    )
    (line,) = [line for line in describe_calibration(calibration).splitlines() if "half_width" in line]
    assert "-" not in line.partition("half_width_rad:")[2] and "stays behind its reading" in line


def moved() -> Poses:
    """Return poses of which joint 2 reaches the last by a long move to a larger angle."""
    columns = {"order": np.arange(4.0)}
    q = np.zeros((4, 6))
    q[:, 1] = [0.1, 0.4, -0.8, 0.9]
    return Poses.from_arrays(q, columns, turning(6))
