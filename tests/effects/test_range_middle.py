"""A curved range: the gain that goes with it cannot be seen, and must not be made up."""

import numpy as np
import pytest

from scalar.diagnosis import diagnose
from scalar.effects.acquisition import range_middle
from scalar.effects.command_line import parse_effects
from scalar.effects.saving import effect_from_mapping, effect_to_mapping
from scalar.estimation.calibrate import calibrate
from scalar.evaluate import evaluate
from tests.effects.injected import Flaws, make_cell


@pytest.mark.parametrize("axis", ["ray", "z"])
def test_a_curvature_in_the_model_brings_predictions_nearer_to_the_truth(axis):
    """A scanner that measures from 0.10 to 0.45 m errs by a parabola about the middle of this range: with the effect the mean error over true poses
    is less than without. About any other middle the parabola has a gain, which leaves no residual and stretches the arm.
    """
    middle = (0.10 + 0.45) / 2
    cell = make_cell(Flaws(measured=lambda r: r + 0.01 * (r - middle) ** 2), seed=31, error_axis=axis)
    assert range_middle(cell.dataset) == pytest.approx(middle, abs=0.02)
    table, _ = cell.truth_poses(500, np.random.default_rng(31))
    effects = parse_effects("range_distortion", cell.dataset)
    with_it, without = (calibrate(cell.dataset, effects=some) for some in (effects, ()))
    errors = [evaluate(c, table).aligned.position.mean() for c in (with_it, without)]
    assert errors[0] < errors[1]


def test_the_middle_does_not_depend_on_where_most_poses_are():
    """With four fifths of the poses at long distances left out, the mean of the ranges falls by centimetres; the middle of their extent stays."""
    dataset = make_cell(seed=33).dataset
    distance = np.array(
        [np.linalg.norm(scan, axis=1).mean() for scan in np.split(dataset.points, dataset.starts[1:-1])]
    )
    long = np.flatnonzero((distance > np.median(distance)) & (distance < np.quantile(distance, 0.98)))
    fewer = dataset.subset(np.setdiff1d(np.arange(dataset.n_poses), long[np.arange(len(long)) % 5 != 0]))
    means = [np.linalg.norm(each.points, axis=1).mean() for each in (dataset, fewer)]
    assert means[1] < means[0] - 0.02
    assert range_middle(fewer) == pytest.approx(range_middle(dataset), abs=0.01)


@pytest.mark.slow
def test_a_zero_beside_a_curvature_has_a_name_of_its_own():
    """For a range that is curved about its middle and 0.4 mm too long, both effects are named, and each alone is named alone."""
    middle = (0.10 + 0.45) / 2
    curvatures = {
        "range_distortion": lambda r: 0.01 * (r - middle) ** 2,
        "range_offset": lambda r: 0 * r + 4e-4,
    }
    for names in (["range_distortion"], ["range_offset"], ["range_distortion", "range_offset"]):
        flaws = Flaws(measured=lambda r, names=names: r + sum(curvatures[name](r) for name in names))
        found = diagnose(make_cell(flaws, seed=34, poses_per_plane=30).dataset).findings
        assert sorted(finding.effect.name for finding in found) == names


def test_the_middle_of_the_range_is_saved():
    """An effect that is read from a calibration is curved about the same range, and one of an older file about zero."""
    (effect,) = parse_effects("range_distortion", make_cell(seed=32, poses_per_plane=10).dataset)
    mapping = effect_to_mapping(effect, [None] * len(effect.coefficients))
    assert effect_from_mapping(mapping).middle == effect.middle
    assert effect_from_mapping(mapping | {"settings": {}}).middle == 0.0
