"""A scanner that errs with the incidence imitates errors of its zero and scale, which are then not named."""

from dataclasses import replace

import numpy as np
import pytest

from scalar.diagnosis import diagnose
from scalar.effects.flexible.incidence import UnattributedIncidence, incidence
from scalar.effects.range_offset import RangeOffset
from scalar.effects.range_scale import RangeScale
from scalar.estimation.calibrate import calibrate
from scalar.estimation.residuals import Residuals
from scalar.sensors.profile import point_basis
from tests.random_scene import make_scene

AT_45_DEGREES = 4e-5  # m


def measured_at_an_angle(scene, size):
    """Return the dataset whose ranges are too long by ``size`` (1 / cos^2 b - 1), b between each point's own ray and the normal of its plane."""
    dataset, truth = scene.dataset, scene.truth
    frames = truth.sensor(dataset.q)
    normals = truth.normals[dataset.plane_index]
    pose = np.repeat(np.arange(dataset.n_poses), np.diff(dataset.starts))
    ray = dataset.points / np.linalg.norm(dataset.points, axis=1, keepdims=True)
    in_base = np.einsum("pij,pj->pi", frames[pose][:, :3, [0, 2]], ray)
    cosine = np.einsum("pi,pi->p", in_base, normals[pose])
    error = size * (1.0 / cosine**2 - 1.0)
    along = ray if dataset.sensor.error_axis == "ray" else np.array([0.0, 1.0])
    return replace(dataset, points=dataset.points + error[:, None] * along)


@pytest.mark.parametrize("error_axis", ["ray", "z"])
def test_the_term_takes_the_error_away(error_axis):
    """Points that err by the exact incidence of their own rays lie on their planes again with the correction, to a tenth."""
    scene = make_scene(kind="line-laser", seed=3, noise=1e-7, error_axis=error_axis)
    wrong = measured_at_an_angle(scene, AT_45_DEGREES)
    model = calibrate(scene.dataset).model
    left = Residuals.of(wrong, model).rms(model)
    (term,) = incidence(wrong)
    corrected = replace(model, effects=(term.with_coefficients([-AT_45_DEGREES]),)).rebased()
    assert Residuals.of(wrong, corrected).rms(corrected) < 0.1 * left
    assert "0.040 mm at 45" in corrected.effects[0].described_as


@pytest.mark.parametrize("normal", [(0.5, 0.1, 0.8), (0.7, 0.0, 0.7), (0.1, 0.2, 0.95)])
def test_the_correction_is_that_of_the_exact_angle(normal):
    """On a plane up to 45 degrees from the scanner's axis, each point's height changes by the exact 1 / cos^2 b - 1 of its ray."""
    n = np.array(normal) / np.linalg.norm(normal)
    x = np.linspace(-0.05, 0.05, 11)
    points = np.column_stack([x, 0.3 - x * n[0] / n[2]])
    ray = points / np.linalg.norm(points, axis=1, keepdims=True)
    along = ray @ n[[0, 2]]
    term = UnattributedIncidence()
    contact = np.array([[-0.3 * n[2], n[0], n[2]]])
    G = term.contact_columns(None, None, None, None, contact)[0, :, 0]
    found = point_basis(term.basis_names, points, "ray") @ G
    np.testing.assert_allclose(found, along * (1.0 / along**2 - 1.0), rtol=1e-12)


def test_only_scanners_of_profiles_have_it():
    """It is a rival of the range's zero and scale, with a scanner of profiles alone."""
    for kind, count in (("line-laser", 1), ("tracker", 0)):
        dataset = make_scene(kind=kind, seed=2, poses_per_plane=6).dataset
        for effect in (RangeOffset(), RangeScale()):
            rivals = [e for e in effect.imitators(dataset) if isinstance(e, UnattributedIncidence)]
            assert len(rivals) == count


@pytest.mark.parametrize("seed", [3, 4, 5])
def test_it_is_no_sure_error_of_zero_or_scale(seed):
    """An error of 0.04 mm at 45 degrees leaves no sure name of a range offset, scale or distortion, and no scale is corrected."""
    scene = make_scene(
        kind="line-laser", seed=seed, poses_per_plane=30, points_per_scan=60, noise=2e-5, angle_error=1e-3
    )
    found = diagnose(measured_at_an_angle(scene, AT_45_DEGREES))
    ranges = [f for f in found.findings if f.effect.name.startswith("range_")]
    assert all(f.confidence < 0.8 for f in ranges)
    assert not any(e.name == "range_scale" for e in found.calibration_after.model.effects)
