"""A scanner whose range drifts until it is warm is not called an arm that grows."""

from dataclasses import replace

import numpy as np
import pytest

from scalar.data.poses import Poses
from scalar.diagnosis import diagnose
from scalar.diagnosis.fit.fitted_state import refit
from scalar.diagnosis.scoring.candidate_columns import named_candidates
from scalar.diagnosis.structure.ranked_terms import flexible_candidate_sets
from scalar.diagnosis.structure.unmodelled_structure import with_flexible_terms
from scalar.effects.flexible.sensor_warm_up import UnattributedSensorWarmUp
from scalar.effects.flexible.variable import Variable
from scalar.effects.flexible.wander import COMPONENTS
from scalar.effects.thermal_drift import ThermalDrift
from scalar.estimation.geometry_fit import geometry_fit
from tests.effects.injected import A, D, Flaws, make_cell
from tests.random_scene import make_scene


def warm_up(order: np.ndarray) -> np.ndarray:
    """Return the course of a warm-up with a time constant of 25 poses ``(N,)``."""
    return 1.0 - np.exp(-order / 25.0)


def grown(at):
    """Return lengths of a VS060 that have grown by 0.6 thousandths once the arm is warm."""
    lengths = make_scene(seed=33, poses_per_plane=2).truth.geometry
    change = np.zeros((len(at.q), *lengths.shape))
    change[:, [A, D]] = 6e-4 * warm_up(at.order)[:, None, None] * lengths[[A, D]]
    return change


def test_its_course_is_that_of_a_warm_up():
    """It moves one component, from nothing at the first pose towards its coefficient; without a time constant it does so in proportion."""
    poses = Poses(np.zeros((3, 6)), np.array([0.0, 10.0, 20.0]), {})
    for constant, expected in (
        (5.0, 1 - np.exp(-np.array([0.0, 2.0, 4.0]))),
        (0.0, np.array([0.0, 0.5, 1.0])),
    ):
        term = UnattributedSensorWarmUp(Variable("order", 10.0, 10.0), "z", constant)
        screws = term.sensor_screws(None, poses)
        np.testing.assert_allclose(screws[:, COMPONENTS.index("z"), 0], expected)
        assert np.count_nonzero(screws.any(axis=(0, 2))) == 1


def test_only_a_scanner_warms_up_in_place_of_the_arm():
    """The growth that a laser measures is imitated by each component of its pose, and that which a tracker measures by none."""
    growth = ThermalDrift("order", 0.0, 25.0, 59.0)
    for kind, count in (("line-laser", len(COMPONENTS)), ("tracker", 0)):
        dataset = make_scene(kind=kind, seed=2, poses_per_plane=20).dataset
        terms = [e for e in growth.imitators(dataset) if isinstance(e, UnattributedSensorWarmUp)]
        assert len(terms) == count and all(term.time_constant == 25.0 for term in terms)


def with_growth(flaws: Flaws):
    """Return the effects of a workcell in which growth was found, after flexible terms have been tried in its place."""
    dataset = make_cell(flaws, seed=33, poses_per_plane=30, points_per_scan=40).dataset
    model, prepared = geometry_fit(dataset)
    growth = ThermalDrift("order", 0.0, 25.0, float(dataset.n_poses - 1))
    state = refit(dataset, model, prepared.free, [growth])
    return with_flexible_terms(state, named_candidates(dataset), flexible_candidate_sets(dataset)).effects


def test_a_drift_of_the_range_takes_the_place_of_a_growth():
    """A range that drifts by 0.3 mm is described as the scanner's, along its line of sight."""
    (found,) = with_growth(Flaws(drift=lambda order: 3e-4 * warm_up(order)))
    assert isinstance(found, UnattributedSensorWarmUp) and found.component == "z"
    assert found.coefficients[0] == pytest.approx(-3e-4, rel=0.3)


def test_a_growth_stays():
    """An arm that grows keeps its name."""
    assert [effect.name for effect in with_growth(Flaws(geometry=grown))] == ["thermal_drift"]


def test_a_scanner_that_gets_warm_is_not_called_a_growth_of_the_arm():
    """Where the range drifts by 0.3 mm, no growth is named for sure, and the sensor is described; an arm that grows is named for sure."""
    for flaws, of_scanner in (
        (Flaws(drift=lambda order: 3e-4 * warm_up(order)), True),
        (Flaws(geometry=grown), False),
    ):
        dataset = make_cell(flaws, seed=33, poses_per_plane=30, points_per_scan=40).dataset
        order = np.arange(float(dataset.n_poses))
        found = diagnose(replace(dataset, poses=dataset.poses.assign(order=order))).findings
        named = {f.effect.name: f.confidence for f in found if f.has_name}
        described = [f.effect.described_as for f in found if not f.has_name]
        assert (named.get("thermal_drift", 0.0) >= 0.8) != of_scanner
        assert any("what sits on the flange" in text for text in described) == of_scanner
