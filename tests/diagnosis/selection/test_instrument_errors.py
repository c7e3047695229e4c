"""A measuring instrument that distorts space is not called an arm that gives way, and an arm that gives way keeps its name."""

import numpy as np
import pytest

from scalar.diagnosis import diagnose
from scalar.diagnosis.selection import instrument_errors
from scalar.diagnosis.selection.instrument_errors import leads_of_instrument
from scalar.effects.base_compliance import BaseCompliance
from scalar.effects.flexible.measured_space import UnattributedSpace
from scalar.effects.joint_scale import JointScale
from tests.diagnosis.erring_arm import erring_arm

NOISE, COUNT = 2e-5, 90


def found_in(joint_1=np.zeros_like, **errors):
    """Return the findings for tracked poses of an arm whose joint 1 errs, with further ``errors`` as of ``erring_arm``."""
    return diagnose(erring_arm(1, joint_1, **errors)).findings


def names(findings, least=0.6):
    """Return the names that have a confidence."""
    return [f.effect.name for f in findings if f.has_name and not f.effect.flexible and f.confidence >= least]


def tilted(p, compliance=2e-4):
    """Return positions on a base that tilts under a weight at them, by 0.2 mrad at one metre."""
    return p + np.cross(compliance * np.cross(p, [0.0, 0.0, -1.0]), p)


STRETCHED = np.eye(3) + np.diag([5e-4, 0.0, 0.0])
SHEARED = np.eye(3) + 3e-4 * np.array([[0, 0, 1], [0, 0, 0], [1, 0, 0]])


@pytest.mark.parametrize("gradient", [STRETCHED, SHEARED], ids=["stretched", "sheared"])
def test_a_distorted_space_gives_no_name(gradient):
    """One axis that is 0.5 mm per m too long, or two that are not at right angles, are described as what they are."""
    found = found_in(instrument=lambda y: y @ gradient.T)
    assert not names(found)
    assert [type(f.effect) for f in found] == [UnattributedSpace]


def test_an_encoder_of_the_instrument_gives_no_name():
    """An azimuth that errs by 100 microradians once a turn is neither a harmonic of joint 1 nor a compliance."""

    def turned(y):
        error = 1e-4 * np.sin(np.arctan2(y[:, 1], y[:, 0]) + 1.0)
        return y + error[:, None] * np.cross([0.0, 0.0, 1.0], y)

    found = found_in(instrument=turned)
    assert not names(found)
    assert any(isinstance(f.effect, UnattributedSpace) for f in found)


def test_a_base_that_gives_way_is_still_named():
    """The compliance keeps its name although a distortion of space imitates it."""
    assert names(found_in(base=tilted), 0.8) == ["base_compliance"]


def test_a_harmonic_of_joint_1_is_still_named():
    """The harmonic keeps its name although a distortion of space imitates it."""
    assert names(found_in(joint_1=lambda q: 2e-4 * np.sin(2 * q)), 0.8) == ["joint_harmonic"]


def test_an_error_that_no_instrument_has_is_not_taken_for_one_and_no_name_is_sure():
    """An axis that is 2 mm per m too long is larger than errors of instruments are: it is not described as one, but it is a rival of every name."""
    found = found_in(instrument=lambda y: y @ (np.eye(3) + np.diag([2e-3, 0.0, 0.0])).T)
    assert not any(isinstance(f.effect, UnattributedSpace) for f in found)
    assert not names(found, 0.8)


def test_a_base_that_gives_way_in_a_distorted_space_is_named_beside_it():
    """Both are found, each as what it is."""
    found = found_in(base=lambda p: tilted(p, 1e-3), instrument=lambda y: y @ STRETCHED.T)
    assert names(found, 0.8) == ["base_compliance"]
    assert any(isinstance(f.effect, UnattributedSpace) for f in found)


def test_an_arm_without_flaws_has_no_distortion():
    """Noise alone gives no finding."""
    assert not found_in()


class Stand:
    """Stands for a fitted state with some effects and a log evidence."""

    def __init__(self, evidence, *effects):
        self.evidence, self.effects = evidence, effects


def test_a_name_that_the_rival_lacks_is_as_sure_as_its_lead_allows(monkeypatch):
    """A model with a distortion leads those names alone that it does without; none where there is no such model, or where it was chosen."""
    monkeypatch.setattr(instrument_errors, "evidence_of", lambda state, candidates: state.evidence)
    space, base, scale = UnattributedSpace("strain"), BaseCompliance((2,)), JointScale(2)
    state, rival = Stand(100.0, base, scale), Stand(98.0, space, scale)
    assert list(leads_of_instrument(state, rival, None)) == [-2.0, -np.inf]
    assert list(leads_of_instrument(state, None, None)) == [-np.inf, -np.inf]
    assert list(leads_of_instrument(rival, rival, None)) == [-np.inf, -np.inf]
