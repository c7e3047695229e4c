"""An error that begins at an angle is no scale error and no harmonic of its joint, which together imitate it."""

import numpy as np
import pytest

from scalar.diagnosis import diagnose
from tests.diagnosis.erring_arm import erring_arm

JOINT = 2


def sure_of(flaw, seed=5, count=120):
    """Return the sure names that a diagnosis of tracked poses gives for an error ``flaw(q)`` [rad] of joint 2 alone."""
    findings = diagnose(erring_arm(JOINT, flaw, seed=seed, count=count)).findings
    return {
        f.effect.name
        for f in findings
        if f.has_name and f.confidence >= 0.8 and f.effect.erring_joint == JOINT
    }


@pytest.mark.parametrize("below", [-0.5, 0.0])
def test_a_spring_on_a_part_of_the_range_is_no_scale_error(below):
    """A spring that pushes only below an angle gives neither a sure scale error nor a sure harmonic."""
    assert not sure_of(lambda q: 2e-3 * np.maximum(below - q, 0.0))


def test_a_scale_error_and_a_harmonic_of_one_joint_are_named():
    """Both are there, and no single term explains them with fewer coefficients."""
    assert sure_of(lambda q: 1e-3 * q + 3e-4 * np.sin(7 * q)) == {"joint_scale", "joint_harmonic"}


def test_a_spring_that_pushes_harder_and_harder_is_no_scale_error():
    """A scale error and a harmonic fit it, and each is better than any term in its place; one smooth term is better than both."""
    assert not sure_of(lambda q: 1e-3 * np.maximum(-0.2 - q, 0.0) ** 2, seed=6)
