"""Changes without a sure name that only the last poses show are not applied to later poses."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from scalar.diagnosis.focused_choice import _is_late
from scalar.effects.flexible.shape import UnattributedShape
from scalar.effects.flexible.variable import Variable
from scalar.effects.joint_scale import JointScale
from scalar.effects.sensor_slip import SensorSlip
from scalar.effects.thermal_drift import ThermalDrift
from scalar.estimation.measured_ranges import measured_columns, ranges_of_columns
from tests.effects.injected import make_cell


def state(n: int = 100):
    """Return a stand-in for a state with n poses, in the order of which the time passes."""
    order = np.arange(n, dtype=float)
    poses = SimpleNamespace(order=order, columns={"time": order})
    poses.column = lambda name: poses.columns[name]
    poses.__len__ = lambda: n
    return SimpleNamespace(residuals=SimpleNamespace(poses=poses))


@pytest.mark.parametrize(
    ("first", "unsure", "is_late"), [(94, True, True), (94, False, False), (80, True, False)]
)
def test_a_doubtful_slip_before_the_last_tenth_is_late(first, unsure, is_late):
    """Six of a hundred poses after a slip without a sure name are too few; twenty are enough, and so is a sure name."""
    slip = SensorSlip(float(first))
    assert _is_late(slip, state(), [slip.key] if unsure else []) == is_late


def test_a_step_in_time_is_late_and_one_over_an_angle_is_none():
    """A flexible term has no name. Only one that begins at a moment can be late."""
    time = Variable("time", 49.5, 49.5)
    step = UnattributedShape(3, (time,), "step", at=0.97, width=0.01)
    assert _is_late(step, state(), [])
    assert not _is_late(replace(step, at=0.2), state(), [])
    assert not _is_late(replace(step, shape="line"), state(), [])
    assert JointScale(2).since(state().residuals.poses) is None


def test_what_effects_follow_is_recorded_with_its_range():
    """Of a growth with the temperature the measured range is stated, and nothing of a scale error."""
    dataset = make_cell(seed=3, poses_per_plane=10).dataset
    dataset = replace(
        dataset, poses=dataset.poses.assign(temperature=np.linspace(18.0, 30.0, dataset.n_poses))
    )
    ranges = ranges_of_columns(dataset, [ThermalDrift("temperature", 21.0), JointScale(2)])
    assert ranges == {"temperature": [18.0, 30.0]}
    assert measured_columns({"measured_columns": ranges})["temperature"].tolist() == [18.0, 30.0]
    assert ranges_of_columns(dataset, [JointScale(2)]) == {} == measured_columns({})
