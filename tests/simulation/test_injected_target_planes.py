"""Injected changes of target planes: ranges to meshes against the analytic surfaces that they stand for."""

import numpy as np
import pytest

from tests.simulation.geometry import fan_hits, sensor_frames
from tests.simulation.injecting import injected

FACET = 1e-6  # m


def rays(scene, k):
    """Return origin (3,) and unit directions (M, 3) of the rays of pose k, by SciPy's kinematics."""
    T = sensor_frames(scene.workcell.arm, scene.q[k : k + 1])[0]
    angles = scene.angles[k]
    return T[:3, 3], np.sin(angles)[:, None] * T[:3, 0] + np.cos(angles)[:, None] * T[:3, 2]


@pytest.mark.parametrize("size", [5e-4, 5e-3])
@pytest.mark.parametrize("plane", ["floor", "wall_x"])
def test_rays_end_on_the_paraboloid(plane, size):
    """On the bent target plane every ray ends on h = c_1 s^2 + c_2 t^2, to a micrometre, and on the others as before."""
    scene = injected({"effect": "plane_bow", "target": {"plane": plane}, "size": size})
    (entry,) = scene.truth["effects"]
    index = [target_plane.name for target_plane in scene.workcell.target_planes].index(plane)
    target_plane = scene.workcell.target_planes[index]
    turn, (c1, c2) = entry["axis_turned_rad"], entry["curvatures_per_m"]
    u, v, w = target_plane.axes.T
    s = np.cos(turn) * u + np.sin(turn) * v
    t = np.cos(turn) * v - np.sin(turn) * u
    middle = target_plane.centre + target_plane.axes[:, :2] @ entry["middle_uv_m"]
    heights = []
    for k in range(len(scene.q)):
        o, direction = rays(scene, k)
        if scene.plane_index[k] != index:
            T = sensor_frames(scene.workcell.arm, scene.q[k : k + 1])[0]
            other = scene.workcell.target_planes[scene.plane_index[k]]
            expected, _, _ = fan_hits(T, scene.angles[k], other.normal, other.distance)
            np.testing.assert_allclose(scene.ranges[k], expected, atol=1e-13, rtol=0)
            continue
        o = o - middle
        # w.(o + r d) = c1 (s.(o + r d))^2 + c2 (t.(o + r d))^2, a quadratic in r; the root on the way to the plane.
        A = c1 * (direction @ s) ** 2 + c2 * (direction @ t) ** 2
        B = 2 * c1 * (direction @ s) * (o @ s) + 2 * c2 * (direction @ t) * (o @ t) - direction @ w
        C = c1 * (o @ s) ** 2 + c2 * (o @ t) ** 2 - o @ w
        root = -2 * C / (B + np.sqrt(B * B - 4 * A * C))
        np.testing.assert_allclose(scene.ranges[k], root, atol=FACET, rtol=0)
        spot = o + root[len(root) // 2] * direction[len(root) // 2]
        heights.append(np.abs(spot @ w))
    assert 0.3 * size < max(heights) < 1.001 * size  # the farthest scan need not lie along the sharper bend


def test_a_knocked_target_plane_stands_elsewhere_from_its_moment_on():
    """Rays end on the plane as it was before, and on the shifted and tilted one from that pose on."""
    entry = {
        "effect": "plane_moved", "size": 8e-4, "tilt_rad": 1e-3,
        "target": {"plane": "wall_y", "at": {"order": 15}},
    }  # fmt: skip
    scene = injected(entry)
    (truth,) = scene.truth["effects"]
    names = [scene.workcell.target_planes[k].name for k in scene.plane_index]
    first = truth["target"]["at"]["order"]
    assert first >= 15 and names[first] == "wall_y" and "wall_y" not in names[15:first]
    assert truth["target"]["at"]["time"] == scene.poses["time"][first]
    target_plane = next(
        target_plane for target_plane in scene.workcell.target_planes if target_plane.name == "wall_y"
    )
    assert abs(truth["along_normal_m"]) == 8e-4
    tilt = np.array(truth["tilt_rad"])
    assert np.linalg.norm(tilt) == pytest.approx(1e-3, abs=1e-15)
    assert tilt @ target_plane.normal == pytest.approx(0.0, abs=1e-15)
    angle = np.linalg.norm(tilt)
    tilted = np.cos(angle) * target_plane.normal + np.sin(angle) / angle * np.cross(tilt, target_plane.normal)
    through = np.array(truth["about_m"]) + truth["along_normal_m"] * target_plane.normal
    for k, T in enumerate(sensor_frames(scene.workcell.arm, scene.q)):
        other = scene.workcell.target_planes[scene.plane_index[k]]
        n, d = other.normal, other.distance
        if other is target_plane and k >= 15:
            n, d = tilted, tilted @ through
        expected, _, _ = fan_hits(T, scene.angles[k], n, d)
        np.testing.assert_allclose(scene.ranges[k], expected, atol=1e-12, rtol=0)


def test_a_target_plane_creeps_in_proportion_to_the_poses_passed():
    """With creep 1 the target plane has moved by nothing at its moment, by half half-way, and by all at the last pose."""
    entry = {
        "effect": "plane_moved", "size": 2e-3, "tilt_rad": 0.0, "creep": 1.0,
        "target": {"plane": "floor", "at": {"order": 5}},
    }  # fmt: skip
    scene = injected(entry)
    (truth,) = scene.truth["effects"]
    start, last = truth["target"]["at"]["order"], len(scene.q) - 1
    floor = next(
        target_plane for target_plane in scene.workcell.target_planes if target_plane.name == "floor"
    )
    for k, T in enumerate(sensor_frames(scene.workcell.arm, scene.q)):
        if scene.workcell.target_planes[scene.plane_index[k]] is floor:
            share = max(k - start, 0) / (last - start)
            lifted = floor.distance + share * truth["along_normal_m"]
            expected, _, _ = fan_hits(T, scene.angles[k], floor.normal, lifted)
            np.testing.assert_allclose(scene.ranges[k], expected, atol=1e-12, rtol=0)


def test_a_bent_target_plane_can_be_knocked_too():
    """If a bent target plane is knocked, every ray to it changes afterwards by what the shift makes of it."""
    bow = {"effect": "plane_bow", "target": {"plane": "floor"}, "size": 2e-3}
    knock = {
        "effect": "plane_moved", "size": 1e-3, "tilt_rad": 0.0,
        "target": {"plane": "floor", "at": {"order": 12}},
    }  # fmt: skip
    bent, both = injected(bow), injected(bow, knock)
    shift = both.truth["effects"][1]["along_normal_m"]
    for k, T in enumerate(sensor_frames(both.workcell.arm, both.q)):
        target_plane = both.workcell.target_planes[both.plane_index[k]]
        moved = shift if target_plane.name == "floor" and k >= 12 else 0.0
        _, cosines, _ = fan_hits(T, both.angles[k], target_plane.normal, target_plane.distance)
        # The face's slope, below 1 %, changes the cosine by as much.
        toward = (
            both.ranges[k]
            - bent.ranges[k]
            + moved * (T[:3, 3] @ target_plane.normal > target_plane.distance) / cosines
        )
        np.testing.assert_allclose(toward, 0.0, atol=0.03 * abs(moved) + 1e-12)
