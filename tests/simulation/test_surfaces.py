"""Faces that are not flat: waves with the stated energy that stay on the target plane, and a target plane that bends."""

import numpy as np
import pytest

from scalar.simulation import simulate
from scalar.simulation.scanner import directions
from scalar.simulation.surfaces import surfaces_of
from tests.simulation.injecting import config_with, plan_of

FLAT = {"waves_m": 0.0, "waves": 5, "wavelengths_m": [0.01, 0.15], "bow_m": 0.0}
WAVY = {"waves_m": 4e-5}


def scene_of(surface, *entries, **changes):
    """Return the small scene with a surface, without noise."""
    return simulate(config_with(*entries, noise={}, surface=surface, **changes), plan=plan_of("ur10e"))


def hits(scene):
    """Return where rays end, (N, M, 3) [m], and the target planes' heights there (N, M) [m] over their planes."""
    T = scene.T_base_sensor
    u = np.einsum("nij,nmj->nmi", T[:, :3, :3], directions(scene.angles))
    points = T[:, None, :3, 3] + scene.ranges[..., None] * u
    planes = [scene.workcell.target_planes[k] for k in scene.plane_index]
    heights = np.array(
        [(p - plane.centre) @ plane.axes[:, 2] for p, plane in zip(points, planes, strict=True)]
    )
    return points, heights, planes


@pytest.mark.parametrize("count", [1, 5, 12])
def test_waves_have_the_stated_energy(count):
    """However many waves there are, the mean square of the height over a large target plane is half the square of the amplitude."""
    planes = scene_of({}).workcell.target_planes
    uv = np.random.default_rng(0).uniform(-1.4, 1.4, (200_000, 2))
    for surface in surfaces_of(FLAT | {"waves_m": 4e-5, "waves": count}, planes, 3):
        assert np.mean(surface.height(uv) ** 2) == pytest.approx(4e-5**2 / 2, rel=0.03)
        lengths = 2 * np.pi / np.linalg.norm(surface.waves, axis=1)
        assert (lengths >= 0.01).all() and (lengths <= 0.15).all()


def test_rays_end_on_the_wavy_face():
    """Where a ray ends, the height over the plane is the surface's own, to a nanometre, at any incidence."""
    scene = scene_of(WAVY | {"bow_m": 3e-4})
    points, heights, planes = hits(scene)
    surfaces = surfaces_of(scene.config["surface"], scene.workcell.target_planes, scene.config["seed"])
    expected = [
        surfaces[k].height((p - plane.centre) @ plane.axes[:, :2])
        for p, plane, k in zip(points, planes, scene.plane_index, strict=True)
    ]
    np.testing.assert_allclose(heights, expected, atol=1e-9)
    assert np.std(heights) > 1e-5


def test_a_place_has_one_height():
    """Waves belong to the target plane: another scene whose sensor stands elsewhere finds the same height at the same place."""
    scene = scene_of(WAVY)
    first = surfaces_of(scene.config["surface"], scene.workcell.target_planes, scene.config["seed"])
    slipped = scene_of(WAVY, {"effect": "sensor_slip", "size": 5e-3, "target": {"at": {"order": 1}}})
    points, heights, planes = hits(slipped)
    expected = [
        first[k].height((p - plane.centre) @ plane.axes[:, :2])
        for p, plane, k in zip(points, planes, slipped.plane_index, strict=True)
    ]
    np.testing.assert_allclose(heights, expected, atol=1e-9)
    assert np.abs(slipped.ranges - scene.ranges).max() > 1e-4


def test_a_bent_target_plane_is_highest_in_its_middle_and_zero_at_its_edges():
    """The height is the first mode of a target plane that is supported along its edges, up or down."""
    planes = scene_of({}).workcell.target_planes
    for surface, plane in zip(surfaces_of(FLAT | {"bow_m": 2e-4}, planes, 5), planes, strict=True):
        assert abs(surface.height(np.zeros(2))) == pytest.approx(2e-4)
        corner = plane.size / 2
        np.testing.assert_allclose(
            surface.height(np.array([corner, [corner[0], 0.0], [0.0, corner[1]]])), 0.0, atol=1e-18
        )


def test_amplitudes_of_zero_give_a_flat_plane():
    """Amplitudes of zero give the very ranges of flat target planes."""
    np.testing.assert_array_equal(scene_of({"waves": 9}).ranges, scene_of({}).ranges)


def test_true_scans_serve_the_same_surface_only():
    """Scans kept from wavy target planes are taken up for the same waves and cast anew for flat ones."""
    wavy, flat = scene_of(WAVY), scene_of({})
    again = simulate(config_with(noise={}, surface={}), plan=plan_of("ur10e"), cast=wavy.true_scans())
    np.testing.assert_array_equal(again.ranges, flat.ranges)
    same = simulate(config_with(noise={}, surface=WAVY), plan=plan_of("ur10e"), cast=wavy.true_scans())
    np.testing.assert_array_equal(same.ranges, wavy.ranges)
