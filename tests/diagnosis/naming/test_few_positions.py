"""A joint that stands at few positions has no sure name if an error of its own at each of them explains as much."""

from dataclasses import replace

import numpy as np
import pytest

from scalar.diagnosis.naming import few_positions
from scalar.diagnosis.naming.few_positions import (
    FREE_ERRORS,
    lead_of_free_errors,
    limited_by_few_positions,
)
from scalar.diagnosis.naming.most_confidence import ONE_OF_TWO
from scalar.diagnosis.scoring.candidate_columns import named_candidates
from scalar.effects.joint_coupling import JointCoupling
from scalar.effects.joint_scale import JointScale
from tests.diagnosis.naming.test_akaike_rivals import tracked
from tests.diagnosis.stand_ins import finding_of
from tests.diagnosis.test_noise_within_scans import before
from tests.kinematics import joint_names

LEAST = 0.6
STEPS = 5  # angles of joint 3


def on_grid(angle):
    """Return the nearest of the angles of a grid over 1.2 rad to either side."""
    return np.linspace(-1.2, 1.2, STEPS)[np.rint((angle + 1.2) * (STEPS - 1) / 2.4).astype(int)]


def lead(error, seed):
    """Return the lead of any error over a scale of joint 3, which stands at angles of the grid and errs by ``error`` of them."""
    dataset = tracked(seed, lambda q: on_grid(q) - q + error(on_grid(q)), most=1.2)
    q = dataset.q.copy()
    q[:, 2] = on_grid(q[:, 2])
    state = before(
        replace(dataset, poses=dataset.poses.assign(**dict(zip(joint_names(6), q.T, strict=True))))
    )
    return lead_of_free_errors(state.refitted([JointScale(3)]), 3, named_candidates(state.dataset))


def drive(angle):
    """Return the error [rad] of a drive with 240 periods a turn."""
    return 6e-4 * np.sin(240 * angle + 0.7)


@pytest.mark.parametrize("seed", range(3))
def test_any_error_leads_where_a_drive_errs_and_a_scale_where_that_is_the_cause(seed):
    """A drive of many periods has an error of its own at each angle of a grid; a scale needs one number for all."""
    assert lead(drive, seed) > 0.0
    assert lead(lambda angle: 6e-4 * angle, seed) < 0.0


def test_only_names_of_that_joint_are_limited(monkeypatch):
    """A name of another joint, and one of two joints, keep their confidence."""
    monkeypatch.setattr(few_positions, "at_few_positions", lambda q: [3, 4])
    monkeypatch.setattr(
        few_positions, "lead_of_free_errors", lambda state, joint, _: 1.0 if joint == 3 else -1.0
    )
    state = before(tracked(0, lambda q: 0.0 * q, most=1.0))
    found = [finding_of(effect, 0.95) for effect in (JointScale(3), JointScale(4), JointCoupling(3, 2))]
    scale, *others = limited_by_few_positions(found, state, named_candidates(state.dataset), LEAST)
    assert (scale.confidence, scale.limit) == (ONE_OF_TWO, FREE_ERRORS)
    assert others == found[1:]
