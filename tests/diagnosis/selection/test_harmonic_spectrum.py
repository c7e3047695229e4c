"""Joints that err in many orders: one smooth error, right at measured angles and tending to zero away from them."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from scalar.data.poses import Poses
from scalar.diagnosis.fit.fitted_state import refit
from scalar.diagnosis.held_out.hold_out import held_out_errors
from scalar.diagnosis.scoring.candidate_columns import named_candidates
from scalar.diagnosis.selection.forward_selection import select_forward
from scalar.diagnosis.selection.harmonic_spectrum import (
    _without_insignificant_series,
    priors_for_whitened_rows,
    with_scaled_priors,
    with_spectrum,
)
from scalar.effects.joint_compliance import JointCompliance
from scalar.effects.joint_harmonic import JointHarmonic
from scalar.effects.joint_scale import JointScale
from scalar.estimation.geometry_fit import geometry_fit
from scalar.estimation.gross_errors import clean
from scalar.estimation.residuals import Residuals
from tests.diagnosis.bumpy_joints import BUMPY_JOINTS, TRACKER_NOISE, bumps, bumpy
from tests.random_scene import make_scene


@pytest.fixture(scope="module")
def found():
    """Return a set in which the upper half of joint 3's range was measured, the model found order by order, and the model with all orders."""
    whole = bumpy(3)
    middle = np.median(whole.q[:, 2])
    seen = np.flatnonzero(whole.q[:, 2] > middle)
    train, fresh = whole.subset(seen[::2]), whole.subset(seen[1::2])
    cleaned = clean(train).dataset
    model, prepared = geometry_fit(cleaned)
    names = named_candidates(cleaned)
    one_by_one = select_forward(refit(cleaned, model, prepared.free, ()), names)
    return fresh, one_by_one, with_spectrum(one_by_one, names)


def rms(dataset, state):
    """Return the root mean square error [m] at poses that took part in no fit."""
    return Residuals.of(dataset, state.model).rms(state.model)


def test_a_sum_of_bumps_becomes_one_smooth_error(found):
    """All orders at once predict new poses better than orders chosen one by one, and no joint without an error is named."""
    fresh, one_by_one, smooth = found
    assert smooth is not one_by_one
    assert rms(fresh, smooth) < rms(fresh, one_by_one)
    assert held_out_errors(smooth).rms < held_out_errors(one_by_one).rms
    assert {e.joint for e in smooth.effects if isinstance(e, JointHarmonic)} == set(BUMPY_JOINTS)


def test_the_correction_fades_where_the_joint_was_not_measured(found):
    """Far from every measured angle the correction is smaller than at measured angles."""
    _, _, smooth = found
    seen = smooth.dataset.q[:, 2]
    beyond = np.linspace(seen.max() + 0.5, seen.min() + 2 * np.pi - 0.5, 200)

    def size(angles):
        q = np.zeros((len(angles), smooth.dataset.q.shape[1]))
        q[:, 2] = angles
        at = Poses(q, np.zeros(len(q)), {})
        mine = [e for e in smooth.effects if isinstance(e, JointHarmonic) and e.joint == 3]
        curve = sum(e.joint_basis(smooth.model.nominal, at)[:, 2] @ e.coefficients for e in mine)
        return np.std(curve)

    assert size(beyond) < 0.5 * size(seen)


def test_a_series_that_predictions_need_is_kept_though_it_is_not_significant(found, monkeypatch):
    """If no series is significant, those of the joints that err are kept, since held-out poses are predicted worse without them; that of a joint
    without an error is dropped.
    """
    _, _, smooth = found
    needless = JointHarmonic(6, tuple(range(1, 33)), term_std=(1e-7,) * 32)
    state = smooth.refitted([*smooth.effects, needless])
    monkeypatch.setattr(
        "scalar.diagnosis.selection.harmonic_spectrum.rivals",
        lambda scored, i, columns: (SimpleNamespace(p_value=0.5), []),
    )
    left = _without_insignificant_series(state, named_candidates(state.dataset))
    kept = {e.joint for e in left.effects if isinstance(e, JointHarmonic)}
    assert kept == set(BUMPY_JOINTS)


@pytest.mark.parametrize("plausible", [True, False])
def test_a_deflection_is_distinguished_from_many_orders(plausible, monkeypatch):
    """A joint that errs in many orders and is deflected by the weight of the next link: both are named, and its orders are one smooth error.

    Joints 2 and 3 are parallel, so the deflection of joint 2 by the next link's weight is a sine of the sum of their angles. If that deflection is
    larger than in any arm, it is not taken.
    """
    if not plausible:
        monkeypatch.setattr(JointCompliance, "natural", {"rad": 1e-6})
    scene = make_scene(kind="tracker", seed=6, poses_per_plane=400, noise=TRACKER_NOISE)
    q2, q3 = scene.dataset.q[:, 1], scene.dataset.q[:, 2]
    landscape, read = bumps(11), q2.copy()
    for _ in range(20):
        read = q2 - landscape(read) - 6e-4 * np.sin(read + q3 + 0.3)
    dataset = scene.dataset.subset(np.flatnonzero(q2 > np.median(q2)))
    dataset = replace(dataset, poses=dataset.poses.assign(q2=read[q2 > np.median(q2)]))
    cleaned = clean(dataset).dataset
    model, prepared = geometry_fit(cleaned)
    names = named_candidates(cleaned)
    after = with_spectrum(select_forward(refit(cleaned, model, prepared.free, ()), names), names)
    assert {e.joint for e in after.effects if isinstance(e, JointHarmonic)} == ({2} if plausible else {2, 3})
    weights = [e for e in after.effects if isinstance(e, JointCompliance)]
    assert [effect.target for effect in weights] == ([{"joints": [2]}] if plausible else [])


def test_a_single_order_stays_one():
    """The error of an eccentric gear is no spectrum: what was found is left as it is."""
    scene = make_scene(kind="tracker", seed=4, poses_per_plane=100, noise=TRACKER_NOISE)
    q = scene.dataset.q[:, 1]
    read = q.copy()
    for _ in range(20):
        read = q - 3e-4 * np.sin(5 * read)
    dataset = clean(replace(scene.dataset, poses=scene.dataset.poses.assign(q2=read))).dataset
    model, prepared = geometry_fit(dataset)
    names = named_candidates(dataset)
    state = select_forward(refit(dataset, model, prepared.free, ()), names)
    assert [e.target for e in state.effects] == [{"joint": 2, "order": 5}]
    assert with_spectrum(state, names) is state
    assert priors_for_whitened_rows(state) is state


def test_only_priors_of_orders_are_scaled():
    """Prior standard deviations of orders are multiplied by the factor; effects without such priors are the same objects as before."""
    own = JointHarmonic(2, (3, 4), term_std=(1e-4, 2e-5))
    common, scale = JointHarmonic(3, (1,)), JointScale(1)
    wide, *rest = with_scaled_priors([own, common, scale], 3.0)
    np.testing.assert_allclose(wide.prior_std, [3e-4, 3e-4, 6e-5, 6e-5])
    assert rest == [common, scale]
    assert JointHarmonic.from_mapping(wide.to_mapping()).term_std == wide.term_std
