"""Fits that cannot succeed are refused in words: no pose in contact, numbers that overflow, more unknowns than equations."""

from dataclasses import replace

import numpy as np
import pytest

import scalar.diagnosis.cleaning as cleaning
import scalar.estimation.calibrate as calibrating
from scalar.data.dataset import Dataset
from scalar.diagnosis import diagnose
from scalar.effects.joint_compliance import JointCompliance
from scalar.effects.joint_harmonic import JointHarmonic
from scalar.errors import InvalidInput, Undetermined
from scalar.estimation.calibrate import calibrate
from scalar.estimation.identifiability import analyse
from scalar.estimation.least_squares import covariance_and_step
from scalar.estimation.model import Model
from scalar.estimation.prepare import candidate_mask
from scalar.estimation.residuals import Residuals
from scalar.geometry.planes import Planes
from scalar.sensors import measure
from tests.random_scene import make_scene


def test_planes_that_no_pose_reaches_are_refused() -> None:
    """With all planes a kilometre away no contact is possible, and nothing can be said of what is determined."""
    dataset = make_scene(kind="probe", poses_per_plane=12, seed=2).dataset
    T = dataset.sensor.T_flange_sensor
    assert T is not None
    far = Planes.at(
        [p.name for p in dataset.planes], np.array([p.normal for p in dataset.planes]), [1e3, 1e3, 1e3]
    )
    model = Model.at(dataset.robot, T, far)
    residuals = Residuals.of(dataset, model, measure(dataset))
    with pytest.raises(Undetermined, match="no pose reaches"):
        analyse(residuals, model, candidate_mask(model))


@pytest.mark.parametrize("value", [np.inf, np.nan, 1e200])
def test_numbers_that_overflow_give_no_covariance_and_no_convergence(value: float) -> None:
    """If a Jacobian or a residual, or its squares, are not finite, the remaining step is infinite and there is no covariance."""
    J, residual = np.ones((4, 2)), np.ones(4)
    for J_, residual_ in ((J * value, residual), (J, residual * value)):
        with np.errstate(all="ignore"):
            covariance, step = covariance_and_step(J_, residual_)
        assert covariance.shape == (2, 2)
        assert step == np.inf
        assert not np.any(np.isfinite(covariance))


def few_poses() -> Dataset:
    """Return a tracked workcell with few poses."""
    return make_scene(kind="tracker", poses_per_plane=14, seed=4).dataset


def test_as_many_unknowns_as_equations_are_refused_without_a_search(monkeypatch: pytest.MonkeyPatch) -> None:
    """Too many effects for the poses are refused with both numbers, and the set-up is not blamed for it."""

    def search(dataset: Dataset) -> None:
        pytest.fail("the set-up is searched for what it cannot explain")

    monkeypatch.setattr(calibrating, "refuse_wrong_setup", search)
    dataset = few_poses()
    n = dataset.robot.n_joints
    effects = [
        JointCompliance(tuple((j, f) for j in range(1, n + 1) for f in range(j, n + 1))),
        *(JointHarmonic(j, tuple(range(1, 17))) for j in range(1, n + 1)),
    ]
    with pytest.raises(Undetermined, match=rf"{dataset.n_poses} poses give {3 * dataset.n_poses} equations"):
        calibrate(dataset, effects=effects)


@pytest.mark.slow
def test_a_known_plane_without_error_does_not_overflow() -> None:
    """A reference plane with so small a standard error that its weight overflows is refused."""
    dataset = make_scene(poses_per_plane=14, points_per_scan=10, seed=4).dataset
    known = replace(dataset.planes[0], distance_std=1e-300, normal_std=1e-300)
    with np.errstate(all="ignore"), pytest.raises(Undetermined):
        calibrate(replace(dataset, planes=(known, *dataset.planes[1:])))


@pytest.mark.parametrize("run", [calibrate, diagnose])
def test_too_few_equations_are_refused_by_counting_without_a_search(run, monkeypatch) -> None:
    """No other reading of the set-up is tried: it would have as many unknowns."""

    def search(dataset: Dataset) -> None:
        raise AssertionError("searched")

    for module in (calibrating, cleaning):
        monkeypatch.setattr(module, "refuse_wrong_setup", search)
    dataset = make_scene(kind="tracker", poses_per_plane=2, seed=2).dataset
    with pytest.raises(Undetermined, match="6 poses give 18 equations"):
        run(dataset)


def test_a_session_for_each_pose_is_what_is_wrong() -> None:
    """The message speaks of the column and does not ask for more poses."""
    dataset = make_scene(kind="tracker", poses_per_plane=20, seed=2).dataset
    dataset = replace(dataset, poses=dataset.poses.assign(session=np.arange(dataset.n_poses)))
    with pytest.raises(
        Undetermined, match=r"column session of poses\.csv has 60 different values"
    ) as refusal:
        calibrate(dataset)
    assert "more poses" not in str(refusal.value)


def test_a_coordinate_that_was_filled_in_is_named() -> None:
    """An arm that moves in all directions has no target with the same z at every pose; one that moves in a plane may have."""
    dataset = make_scene(kind="tracker", poses_per_plane=10, seed=2).dataset
    flat = replace(dataset, points=dataset.points * [1.0, 1.0, 0.0])
    with pytest.raises(InvalidInput, match=r"points\.csv.*column z: every value is 0"):
        calibrate(flat)
    turned = flat.poses.assign(**{f"q{j}": 0.0 for j in range(2, 7)})
    with pytest.raises(Undetermined):  # joint 1 alone moves the flange in a plane
        calibrate(replace(flat, poses=turned))
