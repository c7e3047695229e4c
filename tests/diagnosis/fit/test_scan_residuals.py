"""Pieces of scans: their heights over the planes, and what one effect adds to them."""

import numpy as np
import pytest

from scalar.diagnosis.fit.fitted_state import refit
from scalar.diagnosis.fit.scan_residuals import pieces, signed_residual
from scalar.effects.plane_bow import PlaneBow
from scalar.effects.range_offset import RangeOffset
from scalar.estimation.geometry_fit import geometry_fit
from tests.effects.injected import Flaws, make_cell, target_plane_axes

OFFSET, BEND = 3e-4, 0.02


@pytest.fixture(scope="module")
def cell():
    """Return a workcell with a bent floor, almost free of noise."""
    return make_cell(Flaws(bent={"floor": (BEND, 0.0, 0.0)}), seed=6, poses_per_plane=30, noise=1e-6)


@pytest.fixture(scope="module")
def state(cell):
    """Return the workcell fitted with an offset of the range and without the bow."""
    model, prepared = geometry_fit(cell.dataset)
    return refit(cell.dataset, model, prepared.free, (RangeOffset(coefficients=np.array([OFFSET])),))


def test_an_offset_lifts_every_piece_by_its_share_along_the_normal(state):
    """An offset of the range lifts a point by the offset times the cosine of incidence."""
    (effect,) = state.effects
    found = pieces(state, effect)
    np.testing.assert_allclose(found.of_effect, effect.coefficients[0] * found.incidence, rtol=1e-9)


def test_heights_average_to_the_signed_residual(state):
    """The mean height of a scan's pieces is the residual of its pose, except for the weights of the points."""
    (effect,) = state.effects
    found = pieces(state, effect)
    mean = np.bincount(found.pose, found.height) / np.bincount(found.pose)
    assert np.corrcoef(mean, signed_residual(state))[0, 1] > 0.99


def test_a_bow_explains_the_heights_of_its_plane(cell):
    """With the bow in the model the heights are almost zero, and what it adds is the injected paraboloid up to a plane."""
    dataset = cell.dataset
    model, prepared = geometry_fit(dataset, effects_follow=True)
    fitted = refit(dataset, model, prepared.free, PlaneBow.parsed(dataset, ["floor"]))
    (effect,) = fitted.effects
    found = pieces(fitted, effect)
    mine = (dataset.plane_index == [p.name for p in dataset.planes].index("floor"))[found.pose]
    assert np.abs(found.height[mine]).max() < 2e-5
    u, v, centre = target_plane_axes(cell.scene.truth, "floor")
    flat = np.column_stack([np.ones(mine.sum()), found.position[mine] @ np.column_stack([u, v])])
    injected = BEND * ((found.position[mine] - centre) @ u) ** 2

    def beyond_a_plane(heights):
        return heights - flat @ np.linalg.lstsq(flat, heights, rcond=None)[0]

    difference = beyond_a_plane(-found.of_effect[mine]) - beyond_a_plane(injected)
    assert np.std(difference) < 0.05 * np.std(beyond_a_plane(injected))
