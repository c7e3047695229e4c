"""Planes that are knocked when few of their scans have been taken."""

import numpy as np
import pytest

from scalar.diagnosis.fit.fitted_state import refit
from scalar.diagnosis.scoring.candidate_columns import CandidateColumns, named_candidates
from scalar.diagnosis.selection.joint_selection import select_jointly
from scalar.estimation.geometry_fit import geometry_fit
from tests.effects.injected import Flaws, make_cell


@pytest.fixture(scope="module")
def floor():
    """Return the orders at which the floor is scanned in a campaign of 60 poses, and the campaign's seed."""
    dataset = make_cell(seed=31, poses_per_plane=20).dataset
    name = [plane.name for plane in dataset.planes].index("floor")
    return np.flatnonzero(dataset.plane_index == name), 31


def state_of(knock: float, seed: int):
    """Return the state without effects of a campaign whose floor is lowered by 1 mm and tilted from an order on, and the candidates."""
    flaws = Flaws(moved={"floor": (knock, -1e-3, (1e-3, 0.0))})
    dataset = make_cell(flaws, seed=seed, poses_per_plane=20).dataset
    model, prepared = geometry_fit(dataset)
    return refit(dataset, model, prepared.free, ()), named_candidates(dataset)


def test_a_plane_that_is_knocked_after_four_scans_is_found(floor):
    """Four scans of the floor before the knock show its three coefficients."""
    orders, seed = floor
    state, candidates = state_of(float(orders[4]), seed)
    found = select_jointly(state, state, candidates).effects
    assert [(e.name, e.target["plane"], e.order) for e in found] == [("plane_moved", "floor", orders[4])]


def test_a_slip_of_the_sensor_needs_six_poses(floor):
    """A slip has six coefficients, so it is not looked for before the seventh pose, although a plane's knock is before its fifth scan."""
    orders, seed = floor
    state, candidates = state_of(float(orders[4]), seed)
    changes = CandidateColumns.of(state, candidates).changes(state.background())
    firsts = {
        effect.name + str(effect.target.get("plane", "")): scores.first.min() for effect, scores in changes
    }
    assert firsts["sensor_slip"] == 6
    assert firsts["plane_movedfloor"] == orders[4]
