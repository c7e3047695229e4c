"""Many changes of one kind are doubted; one accident, or two at two places, are not."""

import pytest

from scalar.diagnosis.held_out.hold_out import HeldOutErrors
from scalar.diagnosis.naming.finding import Finding
from scalar.diagnosis.naming.grounds import EFFECT, FinalResiduals, Grounds
from scalar.diagnosis.naming.repeated_changes import repeated_changes_doubted
from scalar.effects import Effect
from scalar.effects.joint_scale import JointScale
from scalar.effects.plane_moved import PlaneMoved
from scalar.effects.restarted_warm_up import RestartedWarmUp
from scalar.effects.sensor_slip import SensorSlip
from scalar.effects.target_drift import TargetDrift
from scalar.effects.thermal_drift import ThermalDrift


def finding(effect: Effect, share: float = 0.5) -> Finding:
    """Return a finding with a high confidence, which explains a share of the residual that is there without it."""
    grounds = Grounds(EFFECT, 50.0, 40.0, share, 1, False, False, FinalResiduals(60, 1.0, 1.0, False, True))
    errors: HeldOutErrors = None  # type: ignore[assignment]
    return Finding(effect, 1e-9, errors, errors, (), 0.98, (), grounds)


def moved(plane: str, order: float) -> Effect:
    """Return a target plane that moved at a pose."""
    return PlaneMoved(plane, order, None, (0.0, 0.0, 0.0))


def warming(constant: float) -> Effect:
    """Return a warm-up of an arm that stood still once, with a time constant [s]."""
    return RestartedWarmUp("time", (0.0, 2000.0), (1000.0, 3000.0), constant)


@pytest.mark.parametrize(
    "effects",
    [
        [moved("a", 10.0)],
        [moved("a", 10.0), moved("b", 30.0)],
        [moved("a", 10.0), SensorSlip(20.0, None), moved("b", 30.0), JointScale(2)],
        [TargetDrift("step", order=46.0), SensorSlip(46.0, None)],
        [warming(300.0), ThermalDrift("temperature", 20.0)],
    ],
)
def test_accidents_at_different_places_keep_their_confidence(effects):
    """One change of a kind, or two at two places, and findings of other kinds, keep their confidence."""
    judged = repeated_changes_doubted([finding(effect) for effect in effects], 0.5)
    assert [f.confidence for f in judged] == [0.98] * len(effects) and not any(f.doubtful for f in judged)


@pytest.mark.parametrize(
    "effects",
    [
        [moved("a", 10.0), moved("a", 30.0)],
        [moved("a", 10.0), moved("b", 20.0), moved("c", 30.0)],
        [SensorSlip(20.0, None), SensorSlip(40.0, None)],
        [ThermalDrift("time", 0.0, 600.0), ThermalDrift("time", 0.0, 90.0)],
        [TargetDrift("order", 0.0, 99.0, (1,)), TargetDrift("step", order=46.0)],
        [ThermalDrift("time", 0.0, 600.0), warming(100.0), warming(900.0)],
    ],
)
def test_repeated_changes_are_all_doubted(effects):
    """If a kind of change is found twice at one place, or three times, none of its names is kept; findings of other kinds keep theirs. A tracker that
    drifts and is knocked as well is found twice at one place, and a drift beside two warm-ups with stops is one growth in three parts.
    """
    judged = repeated_changes_doubted([finding(effect) for effect in [*effects, JointScale(2)]], 0.5)
    assert all(f.doubtful and f.confidence == pytest.approx(0.98 / len(effects)) for f in judged[:-1])
    assert judged[-1].confidence == 0.98 and not judged[-1].doubtful


@pytest.mark.parametrize(
    ("other", "share", "kept"),
    [(moved("a", 30.0), 0.08, True), (moved("a", 30.0), 0.6, False), (moved("b", 30.0), 0.08, True)],
    ids=["a small rest", "a second step", "another plane"],
)
def test_a_change_that_explains_nearly_all_is_one_accident(other, share, kept):
    """A plane that creeps aside is a step and a small rest of the same plane: the step keeps its name and the rest has none."""
    step, rest = repeated_changes_doubted([finding(moved("a", 10.0), 0.9), finding(other, share)], 0.6)
    assert (step.confidence == 0.98) == kept and step.doubtful != kept
    assert rest.doubtful == (other.same_place(moved("a", 10.0)))
