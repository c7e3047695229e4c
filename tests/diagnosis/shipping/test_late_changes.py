"""Changes without a sure name that only the last poses show are not applied to later poses."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from scalar.data.poses import Poses
from scalar.diagnosis.settings import DEFAULTS
from scalar.diagnosis.shipping import doubtful_effects, focused_choice
from scalar.diagnosis.shipping.doubtful_effects import _is_late
from scalar.effects.flexible.shape import UnattributedShape
from scalar.effects.flexible.variable import Variable
from scalar.effects.joint_scale import JointScale
from scalar.effects.sensor_slip import SensorSlip
from scalar.effects.thermal_drift import ThermalDrift
from scalar.estimation.measured_ranges import measured_columns, ranges_of_columns
from tests.effects.injected import make_cell
from tests.turning import turning

COUNT = 100


def at(q: np.ndarray):
    """Return a stand-in for a dataset whose joints stand at ``(N, n)`` [rad] in the order of its rows."""
    robot = SimpleNamespace(slides=np.zeros(q.shape[1], dtype=bool))
    return SimpleNamespace(
        q=q, poses=pd.DataFrame({"order": np.arange(float(len(q)))}), n_poses=len(q), robot=robot
    )


MOVING = at(np.random.default_rng(0).uniform(-2, 2, (COUNT, 3)))
ON_PATH = at(np.sin(np.linspace(0.0, 2.0, COUNT)[:, None] + np.arange(3.0)))


def state(n: int = COUNT):
    """Return a stand-in for a state with n poses, in the order of which the time passes."""
    order = np.arange(n, dtype=float)
    poses = Poses.from_arrays(np.zeros((n, 3)), {"order": order, "time": order}, turning(3))
    return SimpleNamespace(residuals=SimpleNamespace(poses=poses))


@pytest.mark.parametrize(("first", "is_late"), [(94, True), (80, False)])
def test_a_slip_before_the_last_tenth_is_late(first, is_late):
    """Six of a hundred poses after a slip are few; twenty are enough."""
    assert _is_late(SensorSlip(float(first)), state()) == is_late


@pytest.mark.parametrize(
    ("first", "dataset", "unsure", "left_out"),
    [
        (94, MOVING, True, 1),
        (94, MOVING, False, 0),
        (50, MOVING, True, 0),
        (50, ON_PATH, True, 1),
        (50, ON_PATH, False, 0),
    ],
    ids=["late", "late and sure", "in the middle", "on a path", "on a path and sure"],
)
def test_only_a_late_change_or_one_on_a_path_is_not_corrected_without_a_sure_name(
    first, dataset, unsure, left_out, monkeypatch
):
    """A doubtful slip that six of a hundred poses show is not applied to later poses, nor one where the poses follow one path."""
    slip = SensorSlip(float(first))
    wide = SimpleNamespace(errors=lambda kept: (1.0 if kept else 9.0,) * 3, std=lambda kept: 1.0)
    monkeypatch.setattr(focused_choice, "NestedModels", lambda _: wide)
    monkeypatch.setattr(focused_choice, "missing_nuisances", lambda *_: [])
    monkeypatch.setattr(doubtful_effects, "_explain_much", lambda *_: True)
    after = state()
    after.effects, after.dataset, after.settings, after.is_plausible = (slip,), dataset, DEFAULTS, True
    after.refitted = lambda _: SimpleNamespace(is_plausible=True)
    assert len(focused_choice.focused_choice(after, [slip.key] if unsure else []).left_out) == left_out


@pytest.mark.parametrize(
    ("unsure", "steps", "left_out"),
    [(True, 5, 1), (False, 5, 0), (True, 100, 0)],
    ids=["grid", "sure", "no grid"],
)
def test_an_error_of_a_joint_at_few_positions_is_corrected_only_with_a_sure_name(
    unsure, steps, left_out, monkeypatch
):
    """A doubtful scale of a joint that stands at five angles is left out; a sure one is not, nor is one of a joint that stands everywhere."""
    scale, q = JointScale(2), MOVING.q.copy()
    q[:, 1] = 0.02 * (np.arange(100) % steps)
    wide = SimpleNamespace(errors=lambda kept: (1.0 if kept else 9.0,) * 3, std=lambda kept: 1.0)
    monkeypatch.setattr(focused_choice, "NestedModels", lambda _: wide)
    monkeypatch.setattr(focused_choice, "missing_nuisances", lambda *_: [])
    monkeypatch.setattr(doubtful_effects, "_explain_much", lambda *_: True)
    after = state()
    after.effects, after.dataset, after.settings, after.is_plausible = (
        (scale,),
        at(q),
        DEFAULTS,
        True,
    )
    after.refitted = lambda _: SimpleNamespace(is_plausible=True)
    assert len(focused_choice.focused_choice(after, [scale.key] if unsure else []).left_out) == left_out


def test_a_step_in_time_is_late_and_one_over_an_angle_is_none():
    """A flexible term has no name. Only one that begins at a moment can be late."""
    time = Variable("time", 49.5, 49.5)
    step = UnattributedShape(3, (time,), "step", at=0.97, width=0.01)
    assert _is_late(step, state())
    assert not _is_late(replace(step, at=0.2), state())
    assert not _is_late(replace(step, shape="line"), state())
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
