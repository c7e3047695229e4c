"""Refits share the rows of a dataset: its points are compressed only when distances are first needed, and once."""

from itertools import count

import numpy as np
import pytest

from scalar.diagnosis.fit.fitted_state import refit
from scalar.diagnosis.fit.measured_rows import MeasuredRows
from scalar.effects.command_line import parse_effects
from scalar.estimation.geometry_fit import geometry_fit
from scalar.sensors import profile
from tests.diagnosis.cases import scale
from tests.effects.injected import make_cell
from tests.random_scene import make_scene

REFITS = ("joint_scale:3", "joint_scale:3,joint_harmonic:2:4", "base_compliance", "")


@pytest.fixture
def compressed(monkeypatch):
    """Return a list to which every compression of all scans adds its number of functions of a point."""
    widths = []
    compress, line_factors = profile.compress, profile.line_factors

    def counted(basis, starts):
        widths.append(basis.shape[1])
        return compress(basis, starts)

    def counted_lines(points, starts, *weights):
        widths.append(3)
        return line_factors(points, starts, *weights)

    monkeypatch.setattr(profile, "compress", counted)
    monkeypatch.setattr(profile, "line_factors", counted_lines)
    return widths


def test_scans_are_compressed_once_however_often_is_refitted(compressed):
    """Refits compress no scan; the distances of all of them need one compression."""
    dataset = scale(1, poses_per_plane=20)[0].dataset
    model, prepared = geometry_fit(dataset)
    compressed.clear()
    state = refit(dataset, model, prepared.free, ())
    for effects in REFITS:
        state = state.refitted(parse_effects(effects, dataset))
        assert compressed == []
    for effects in REFITS:
        state = state.refitted(parse_effects(effects, dataset))
        state.residuals.pose_distances(state.model)
    assert compressed == [3]


def test_functions_that_an_effect_needs_are_compressed_once_more(compressed):
    """An effect of the laser needs the direction of the ray: this takes one more compression for the distances of all refits with such effects."""
    dataset = make_cell(seed=2, poses_per_plane=20).dataset
    model, prepared = geometry_fit(dataset)
    state = refit(dataset, model, prepared.free, ())
    state.residuals.pose_distances(state.model)
    compressed.clear()
    for effects in ("range_offset", "range_offset,joint_scale:2", "joint_scale:2", "range_offset"):
        state = state.refitted(parse_effects(effects, dataset))
        state.residuals.pose_distances(state.model)
    assert len(compressed) == 1 and compressed[0] > 3


@pytest.mark.parametrize("stated", [1e-4, None])
def test_shared_rows_give_the_answer_of_fresh_ones(stated):
    """A refit on shared rows is, to the last bit, the refit on rows compressed for it alone, whether or not the noise is stated."""
    dataset = make_cell(seed=3, poses_per_plane=20, stated_noise=stated).dataset
    model, prepared = geometry_fit(dataset)
    effects = parse_effects("joint_scale:3,range_offset", dataset)
    start = refit(dataset, model, prepared.free, ())
    shared = start.refitted(effects)
    fresh = refit(dataset, start.model, prepared.free, effects)
    assert shared.rows is start.rows and fresh.rows is not start.rows
    np.testing.assert_array_equal(shared.model.vector, fresh.model.vector)
    assert shared.residuals.measurement.sigma == fresh.residuals.measurement.sigma


def test_a_result_that_all_models_share_is_computed_once_for_what_it_depends_on():
    """What depends on the poses and thresholds alone is computed once for the same key, and again for another one."""
    rows = MeasuredRows(make_scene(seed=1, poses_per_plane=5).dataset)
    counted = count()
    results = [rows.once(key, lambda: next(counted)) for key in (("a", 1), ("a", 1), ("a", 2), ("a", 1))]
    assert results == [0, 0, 1, 0]
