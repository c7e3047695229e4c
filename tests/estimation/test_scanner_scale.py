"""An error of the scanner's scale that leaves no residual is stated with the shift of predicted positions that it causes."""

from dataclasses import replace

import numpy as np
import pytest

from scalar.estimation.calibrate import calibrate
from scalar.estimation.result import Calibration
from scalar.report.scale_words import scanner_scale_in_words
from tests.random_scene import make_scene


@pytest.fixture(scope="module")
def scene():
    """Return sixty scans of three planes of unknown place."""
    return make_scene("vs060", "line-laser", poses_per_plane=20, noise=1e-5, seed=4)


@pytest.fixture(scope="module")
def calibration(scene):
    """Return their calibration."""
    return calibrate(scene.dataset)


def test_the_stated_shift_is_that_of_a_scanner_with_another_scale(scene, calibration):
    """Three times the natural error of the scale, in the points themselves, moves predictions by three times the stated shift, without a residual."""
    stretched = calibrate(replace(scene.dataset, points=1.003 * scene.dataset.points))
    q = scene.truth.poses(500, np.random.default_rng(0))[[f"q{i}" for i in range(1, 7)]].to_numpy()
    moved = stretched.predict(q)[:, :3, 3] - calibration.predict(q)[:, :3, 3]
    rms = float(np.sqrt(np.mean(np.sum(moved**2, axis=1))))
    assert 3.0 * calibration.summary["scanner_scale_shift_m"] == pytest.approx(rms, rel=0.05)
    assert stretched.residual_rms < 1.1 * calibration.residual_rms


def test_the_shift_is_said_and_kept(calibration, tmp_path):
    """The sentence states the shift and what to do, and a saved calibration says it again."""
    calibration.save(tmp_path / "c.json")
    said = scanner_scale_in_words(Calibration.load(tmp_path / "c.json"))
    assert "if it measures 0.1 % too long or too short" in said and "about 0.5 mm" in said


def test_known_planes_check_the_scale(scene):
    """With the places of all planes declared known, the data show the scale, and nothing is said."""
    truth = scene.truth
    planes = tuple(
        replace(plane, normal=normal, distance=float(distance), distance_std=1e-5, normal_std=1e-5)
        for plane, normal, distance in zip(scene.dataset.planes, truth.normals, truth.distances, strict=True)
    )
    assert scanner_scale_in_words(calibrate(replace(scene.dataset, planes=planes))) == ""


def test_sensors_without_ranges_have_no_such_scale():
    """A tracker's lengths are its own, and it is not asked about."""
    assert scanner_scale_in_words(calibrate(make_scene("vs060", "tracker", poses_per_plane=15).dataset)) == ""
