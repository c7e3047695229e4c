"""What goes with an arm to its next campaign: its joints and links do, what happened on one day in one workcell does not."""

from dataclasses import replace

import numpy as np
import pytest

from scalar.errors import InvalidInput
from scalar.estimation.result import Calibration
from scalar.estimation.transfer import carried
from tests.effects.everything import every_effect, optional_columns
from tests.random_scene import make_scene

STAYS = {"restarted_warm_up", "target_drift", "sensor_slip", "plane_moved", "plane_bow", "pose_lag"}
GOES = {
    "joint_compliance",
    "joint_harmonic",
    "joint_ripple",
    "joint_scale",
    "joint_coupling",
    "axis_nonparallel",
    "base_compliance",
}


@pytest.fixture(scope="module")
def cell():
    """Return a dataset with every optional column, and a model with every effect."""
    rng = np.random.default_rng(5)
    dataset = make_scene(seed=5, poses_per_plane=10, points_per_scan=5).dataset
    columns = optional_columns(rng, dataset.n_poses, dataset.robot.n_joints)
    dataset = replace(dataset, poses=dataset.poses.assign(**columns))
    model = Calibration.nominal(dataset, np.eye(4)).model
    return dataset, replace(model, effects=tuple(every_effect(dataset, rng)))


def test_effects_of_the_arm_are_transferred_and_those_of_a_campaign_are_not(cell):
    """Effects of joints, links and pedestal are carried with their coefficients.

    Slips, target planes and warm-ups by the clock are not, with a reason.
    """
    dataset, model = cell
    given = carried(model, dataset)
    names = {effect.name for effect in given.effects}
    assert names >= GOES and not names & STAYS
    by_clock = {id(e) for e in model.effects if e.name == "thermal_drift" and e.by != "temperature"}
    left = {id(e) for e, reason in given.left if reason}
    assert by_clock <= left
    assert {id(e) for e in given.effects} | left == {id(e) for e in model.effects}


@pytest.mark.parametrize(
    ("column", "name"), [("temperature", "thermal_drift"), ("approach2", "joint_backlash")]
)
def test_an_effect_whose_column_is_missing_is_left_with_the_columns_name(cell, column, name):
    """An effect that needs a column is transferred only if the dataset has it, and the message names the column."""
    dataset, model = cell
    poorer = replace(dataset, poses=dataset.poses.drop(columns=column))
    rich, poor = carried(model, dataset), carried(model, poorer)
    kept = [id(e) for e in poor.effects]
    lost = [e for e in rich.effects if id(e) not in kept]
    assert [e.name for e in lost] == [name]
    assert column in dict((id(e), reason) for e, reason in poor.left)[id(lost[0])]


def test_another_arm_is_refused(cell):
    """Effects of an arm with another number of joints, another table of joints or another kind of joint are refused, with what differs."""
    dataset, model = cell
    ours = dataset.robot
    longer = ours.geometry.copy()
    longer[0, 2] += 0.05
    others = [
        (replace(ours, geometry=ours.geometry[:, :5], limits=ours.limits[:5]), "6 joints"),
        (ours.with_geometry(longer), "another arm: nominal a_3 is"),
        (replace(ours, prismatic=(3,)), "another arm: joint 4 turns there and slides"),
    ]
    for other, words in others:
        with pytest.raises(InvalidInput, match=words):
            carried(model, replace(dataset, robot=other))


def test_the_same_arm_in_another_workcell_is_taken(cell):
    """Another name, base, tool and limits, a table with rounded numbers and an angle written with a turn more are those of the same arm."""
    dataset, model = cell
    ours = dataset.robot
    T = np.eye(4)
    T[:3, 3] = 0.1, -0.2, 0.3
    rounded = ours.geometry.round(3)
    rounded[3, 1] += 2.0 * np.pi
    same = replace(
        ours, name="cell 2", geometry=rounded, limits=0.5 * ours.limits, T_base_0=T, T_n_flange=T @ T
    )
    given = carried(model, replace(dataset, robot=same))
    assert {effect.name for effect in given.effects} >= GOES
