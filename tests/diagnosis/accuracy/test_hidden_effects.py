"""Effects that every arm has, and that the data do not show: what a fit leaves open of them is what a fit with them would leave open."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from scalar.diagnosis.accuracy.hidden_effects import PRIOR_SHARE, HiddenEffects
from scalar.diagnosis.fit.fitted_state import FittedState, state_of
from scalar.effects.axis_nonparallel import AxisNonparallel
from scalar.effects.joint_compliance import JointCompliance
from scalar.estimation.calibrate import calibrate
from scalar.estimation.displacement import displacement_columns
from tests.diagnosis.tracked_arm import fitted_arm, others


@pytest.fixture(scope="module")
def state() -> FittedState:
    """Return the fit of a tracked arm of 40 poses, without effects."""
    return fitted_arm()


def test_every_arm_gives_way_and_has_tilted_axes(state: FittedState):
    """The kinds are those that no arm is without; none of them has to be found first."""
    hidden = HiddenEffects.of(state)
    assert hidden is not None
    assert {type(effect) for effect in hidden.missing.effects} == {AxisNonparallel, JointCompliance}
    assert not any(effect.coefficients.any() for effect in hidden.missing.effects)


def test_what_is_left_open_is_that_of_a_fit_with_these_effects(state: FittedState):
    """By dense normal equations with a prior: covariance and mean of predictions with the effects exceed those without by the deviations."""
    hidden = HiddenEffects.of(state)
    assert hidden is not None
    r, J = state.linearised()
    E = state.columns_within_scans(hidden.missing.effects)
    E = np.vstack([E, np.zeros((len(J) - len(E), E.shape[1]))])
    F, K = J.shape[1], E.shape[1]
    std = PRIOR_SHARE * np.concatenate([effect.natural_sizes for effect in hidden.missing.effects])
    variance = max(np.sum((r - J @ np.linalg.lstsq(J, r, rcond=None)[0]) ** 2) / (len(J) - F), 1.0)
    rows = np.vstack([np.hstack([J, E]) / np.sqrt(variance), np.hstack([np.zeros((K, F)), np.diag(1 / std)])])
    target = np.r_[r / np.sqrt(variance), np.zeros(K)]
    both = np.linalg.lstsq(rows, -target, rcond=None)[0]
    alone = np.linalg.lstsq(J, -r, rcond=None)[0]
    inverse, inverse_alone = np.linalg.pinv(rows), np.linalg.pinv(J / np.sqrt(variance))

    poses = others()
    with_effects = displacement_columns(replace(state.model, effects=hidden.missing.effects), poses)
    P = len(state.free)
    columns = np.hstack([with_effects[:, :P][:, state.free], with_effects[:, P:]])
    expected = columns @ (inverse @ inverse.T) @ columns.T
    expected -= columns[:, :F] @ (inverse_alone @ inverse_alone.T) @ columns[:, :F].T
    deviations = hidden.deviations(poses)
    found = deviations[:, :-1] @ deviations[:, :-1].T
    np.testing.assert_allclose(found, expected, atol=1e-6 * np.abs(expected).max())
    mean = columns @ both - columns[:, :F] @ alone
    np.testing.assert_allclose(deviations[:, -1], mean, atol=1e-6 * np.abs(mean).max())


def test_a_calibration_leaves_open_what_its_fit_does(state: FittedState):
    """From calibration.json's model and the dataset, the deviations are those of the diagnosis' own fit of the same poses."""
    calibration = calibrate(state.dataset)
    of_calibration, of_state = (
        HiddenEffects.of(state_of(calibration, state.dataset)),
        HiddenEffects.of(state),
    )
    assert of_calibration is not None and of_state is not None
    sizes = [np.linalg.norm(hidden.deviations(others()), axis=1) for hidden in (of_calibration, of_state)]
    np.testing.assert_allclose(sizes[0], sizes[1], rtol=0.05)
