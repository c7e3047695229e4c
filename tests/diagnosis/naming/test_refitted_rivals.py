"""A rival that a linear score puts behind an effect by its own error is fitted, and has the gain of the fit where that is larger."""

from types import SimpleNamespace

import pytest

from scalar.diagnosis.naming import refitted_rivals
from scalar.diagnosis.naming.refitted_rivals import with_fitted_rivals
from scalar.diagnosis.scoring.ranking import Scored
from scalar.diagnosis.settings import DEFAULTS
from scalar.effects.base_compliance import BaseCompliance
from scalar.effects.joint_compliance import JointCompliance
from scalar.effects.joint_scale import JointScale

REST, DOF = 900.0, 850.0  # sum of squares of the state, and degrees of freedom without the effect
BASE, JOINT = BaseCompliance((2, 3), True), JointCompliance(((2, 2), (2, 3)))


@pytest.fixture
def state(monkeypatch):
    """Return a function that makes a stand-in for a state with the base that gives way.

    Its arguments: the gain of the base, the sum of squares that a fit with a rival in its place leaves, and whether that fit is plausible.
    """

    def make(gain, left, plausible=True):
        without = SimpleNamespace(
            sum_of_squares=REST + gain,
            degrees_of_freedom=DOF,
            variance=1.0,
            settings=DEFAULTS.score_test,
        )
        monkeypatch.setattr(refitted_rivals, "background_without", lambda *_: (without, None, None))
        fits = []

        def refitted(effects):
            fits.append(effects)
            return SimpleNamespace(
                background=lambda: SimpleNamespace(sum_of_squares=left), is_plausible=plausible
            )

        return SimpleNamespace(
            effects=(BASE,),
            background=lambda: SimpleNamespace(sum_of_squares=REST),
            refitted=refitted,
            fits=fits,
        )

    return make


def score(effect, gain, evidence):
    """Return a score with four degrees of freedom."""
    return Scored(effect, gain, 4, evidence, 1e-9, 1.0)


def test_a_rival_that_fits_as_well_is_level_with_the_effect(state):
    """A joint whose linear gain is 60 of 75,000 too small, but whose fit leaves what the base leaves, gets the evidence of the base."""
    own, rival = score(BASE, 75_000.0, 1850.0), score(JOINT, 74_940.0, 1822.0)
    found = with_fitted_rivals(state(75_000.0, REST), 0, own, [own, rival])
    assert found[1].gain == pytest.approx(own.gain)
    # The rest is 960 instead of 900: half the degrees of freedom times the logarithm of their ratio.
    assert found[1].evidence == pytest.approx(1822.0 + 27.43, abs=0.01)


@pytest.mark.parametrize(
    ("rival", "left", "plausible", "fits"),
    [
        (score(JointScale(2), 74_940.0, 1822.0), REST, True, 0),
        (score(JOINT, 70_000.0, 1200.0), REST, True, 0),
        (score(JOINT, 74_940.0, 1822.0), 2 * REST, True, 1),
        (score(JOINT, 74_940.0, 1822.0), REST, False, 1),
        (score(JOINT, 74_990.0, 1900.0), REST, True, 0),
        (score(BaseCompliance((2, 3), True), 74_940.0, 1822.0), REST, True, 0),
    ],
    ids=["no load", "far behind", "worse fit", "implausible fit", "ahead already", "the same answer"],
)
def test_other_scores_stay(state, rival, left, plausible, fits):
    """No other rival has another score: under no load, far behind, with a worse or an implausible fit, ahead already, or the same answer."""
    own, at = score(BASE, 75_000.0, 1850.0), state(75_000.0, left, plausible)
    assert rival in with_fitted_rivals(at, 0, own, [own, rival])
    assert len(at.fits) == fits
