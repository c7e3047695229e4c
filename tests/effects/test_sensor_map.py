"""A scanner that errs smoothly over its profile: the map is named, and where the data determine it, predictions come nearer to the truth."""

from dataclasses import replace

import numpy as np
import pytest

from scalar.data.dataset import Dataset
from scalar.diagnosis import diagnose
from scalar.effects.sensor_map import TERMS, SensorMap
from scalar.evaluate import aligned_to, pose_errors, true_frames
from scalar.sensors.profile import point_basis
from tests.effects.injected import make_cell
from tests.random_scene import make_scene


def crooked(dataset: Dataset, seed: int, size: float = 5e-5) -> Dataset:
    """Return a dataset whose scanner has a lens of waves: no polynomial, so nothing that the map's own formula made [m]."""
    rng = np.random.default_rng([90, seed])
    x, z = dataset.points.T
    u, v = x / 0.06, (z - z.mean()) / 0.08
    waves = [np.sin(a * u + b * v + c) for a, b, c in rng.uniform([0.3, 0.3, 0], [1.2, 1.2, 6], (3, 3))]
    error = size * sum(waves) / np.sqrt(1.5)
    straight = np.column_stack([np.ones_like(x), x, z])
    error -= straight @ np.linalg.lstsq(straight, error, rcond=None)[0]  # what the maker has taken away
    return replace(
        dataset, points=dataset.points * (1.0 + error / np.linalg.norm(dataset.points, axis=1))[:, None]
    )


def mean_error(calibration, cell) -> float:
    """Return the mean error of predicted positions over 500 random poses, the base aligned [m]."""
    table, _ = cell.truth_poses(500, np.random.default_rng(91))
    T = true_frames(table)
    return float(pose_errors(T, aligned_to(T, calibration.predict(table))).position.mean())


@pytest.mark.parametrize("error_axis", ["ray", "z"])
def test_powers_and_polynomials_are_the_same_map(error_axis):
    """The products of powers from which rows are compressed give each Legendre term along the direction in which the scanner errs."""
    rng = np.random.default_rng(92)
    points = rng.uniform([-0.1, 0.2], [0.1, 0.5], (50, 2))
    planes = tuple(map(tuple, rng.standard_normal((len(TERMS), 3)).tolist()))
    effect = SensorMap((0.01, 0.33), (0.09, 0.17), planes)
    c = rng.standard_normal((1, 3))
    columns = effect.contact_columns(None, np.eye(4)[None], None, np.zeros(1, int), c)[0]  # type: ignore[arg-type]
    along = point_basis(("ux", "uz"), points, error_axis) @ c[0, 1:]
    wanted = along[:, None] * effect.terms_at(*points.T)
    np.testing.assert_allclose(
        point_basis(effect.basis_names, points, error_axis) @ columns, wanted, atol=1e-9
    )


def test_terms_of_higher_degree_have_no_slope_where_the_points_lie():
    """A plane over x and z, fitted to such a term at the measured points, is zero, so that the term cannot stand for a length of the arm."""
    dataset = make_scene(seed=4).dataset
    (effect,) = SensorMap.candidates(dataset)
    assert isinstance(effect, SensorMap)
    x, z = dataset.points.T
    straight = np.column_stack([np.ones_like(x), x - x.mean(), z - z.mean()])
    slopes = np.linalg.lstsq(straight, effect.terms_at(x, z), rcond=None)[0]
    higher = np.array([i + j > 1 for i, j in TERMS])
    np.testing.assert_allclose(slopes[:, higher], 0.0, atol=1e-9)
    assert np.abs(slopes[1:, ~higher]).max(axis=0).min() > 1


def test_a_map_of_an_older_file_is_read_as_it_was_written():
    """Without planes in the file none is taken off, so that an old calibration predicts what it did."""
    effect = SensorMap.from_mapping({"middle_m": [0.0, 0.3], "half_m": [0.1, 0.2]})
    assert effect.terms_at(np.array([0.1]), np.array([0.5])).tolist() == [[1.0] * len(TERMS)]


def test_only_a_scanner_of_profiles_has_a_map():
    """A tracker has no sensor map, and a request for one is refused with that reason."""
    dataset = make_scene(kind="tracker", seed=1).dataset
    assert SensorMap.candidates(dataset) == []
    with pytest.raises(ValueError, match="profiles"):
        SensorMap.parsed(dataset, ())


@pytest.mark.slow
def test_a_crooked_scanner_is_named():
    """The error of a crooked scanner is named as a fault of the scanner over its profile, and nothing else is named."""
    for seed in range(3):
        cell = make_cell(seed=95 + seed, poses_per_plane=60, points_per_scan=60, noise=4e-5)
        diagnosis = diagnose(crooked(cell.dataset, 10 + seed, 6e-5))
        assert [f.effect.name for f in diagnosis.findings] == ["sensor_map"]
