"""Injected changes of links, base and sensor: frames by SciPy's kinematics, readings by hand."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from scalar.errors import InvalidInput
from tests.simulation.geometry import masses_at, sensor_frames
from tests.simulation.injecting import angles_in, injected

EXACT = {"atol": 1e-12, "rtol": 0}


def test_an_axis_leans_by_hayatis_angle():
    """The arm stands as one whose beta of that joint is the size, and so do the parameters in truth.json."""
    scene = injected({"effect": "axis_nonparallel", "target": {"joint": 3}, "size": 2e-3})
    leaning = replace(scene.workcell.arm, beta=np.array([0, 0, 2e-3, 0, 0, 0]))
    np.testing.assert_allclose(scene.T_base_sensor, sensor_frames(leaning, scene.q), **EXACT)
    assert scene.truth["parameters"]["beta"] == [0, 0, 2e-3, 0, 0, 0]
    table = scene.truth_poses
    T = sensor_frames(leaning, angles_in(table, 6))
    np.testing.assert_allclose(table[["x", "y", "z"]].to_numpy(), T[:, :3, 3], **EXACT)


@pytest.mark.parametrize(
    ("scene", "joint", "message"),
    [("ur10e", 2, "is not parallel"), ("panda", 3, "is not parallel"), ("panda", None, "no axis parallel")],
)
def test_only_parallel_axes_can_stop_being_parallel(scene, joint, message):
    """Elsewhere such a tilt is a parameter of the model, and is refused by its place in the config."""
    target = {} if joint is None else {"joint": joint}
    with pytest.raises(InvalidInput, match=rf"injected\[0\]\.target.*{message}"):
        injected({"effect": "axis_nonparallel", "target": target}, scene=scene)


@pytest.mark.parametrize("profile", ["proportional", "warm_up"])
@pytest.mark.parametrize("by", ["temperature", "time"])
def test_lengths_grow_with_what_is_recorded(by, profile):
    """Lengths grow along the recorded column, from zero at the first pose to the size at the last, which evaluation poses have."""
    lengths = ["a_3", "d_1"]
    entry = {"effect": "thermal_drift", "by": by, "profile": profile, "lengths": lengths, "size": 1e-3}
    scene = injected(entry)
    x = scene.poses[by].to_numpy()
    share = (x - x[0]) / (x[-1] - x[0])
    if profile == "warm_up":
        share = (1 - np.exp(-3 * share)) / (1 - np.exp(-3))
    arm = scene.workcell.arm
    a, d = np.tile(arm.a, (len(x), 1)), np.tile(arm.d, (len(x), 1))
    a[:, 2] *= 1 + 1e-3 * share
    d[:, 0] *= 1 + 1e-3 * share
    T = [sensor_frames(replace(arm, a=a[k], d=d[k]), scene.q[k : k + 1])[0] for k in range(len(x))]
    np.testing.assert_allclose(scene.T_base_sensor, T, **EXACT)
    table = scene.truth_poses
    assert (table[by] == x[-1]).all()
    T = sensor_frames(replace(arm, a=a[-1], d=d[-1]), angles_in(table, 6))
    np.testing.assert_allclose(table[["x", "y", "z"]].to_numpy(), T[:, :3, 3], **EXACT)


def test_all_lengths_grow_where_none_is_named():
    """At the end of the run a robot without a named link is larger, to scale."""
    scene = injected({"effect": "thermal_drift", "size": 1e-3})
    arm = scene.workcell.arm
    grown = replace(arm, a=arm.a * 1.001, d=arm.d * 1.001)
    np.testing.assert_allclose(scene.T_base_sensor[-1], sensor_frames(grown, scene.q[-1:])[0], **EXACT)
    np.testing.assert_allclose(scene.T_base_sensor[0], sensor_frames(arm, scene.q[:1])[0], **EXACT)


@pytest.mark.parametrize("pivot", [[0.0, 0.0, 0.0], [0.1, -0.2, -0.8]])
def test_the_pedestal_tilts_by_the_moment_of_the_weight(pivot):
    """The whole arm turns about the pivot by size times sum m (r - pivot) x g, with masses placed by SciPy's kinematics."""
    scene = injected({"effect": "base_compliance", "size": 5e-6, "pivot_m": pivot})
    arm = scene.workcell.arm

    def expected(q):
        where, masses = masses_at(arm, q)
        moments = np.cross(np.einsum("l,nli->ni", masses, where - pivot), arm.gravity)
        R = Rotation.from_rotvec(5e-6 * moments).as_matrix()
        T = sensor_frames(arm, q)
        T[:, :3, 3] = np.einsum("nij,nj->ni", R, T[:, :3, 3] - pivot) + pivot
        T[:, :3, :3] = R @ T[:, :3, :3]
        return T, moments

    T, moments = expected(scene.q)
    np.testing.assert_allclose(scene.T_base_sensor, T, atol=1e-11, rtol=0)
    largest = 5e-6 * np.linalg.norm(moments, axis=1).max()
    assert scene.truth["effects"][0]["largest_tilt_rad"] == pytest.approx(largest, rel=1e-9)
    table = scene.truth_poses
    T, _ = expected(angles_in(table, 6))
    np.testing.assert_allclose(table[["x", "y", "z"]].to_numpy(), T[:, :3, 3], atol=1e-11, rtol=0)


def test_a_slip_moves_the_sensor_from_one_pose_on():
    """Before its moment the sensor is in its place, and afterwards and at the evaluation poses it is off by size metres and radians."""
    scene = injected({"effect": "sensor_slip", "target": {"at": {"order": 20}}, "size": 3e-3})
    (entry,) = scene.truth["effects"]
    assert entry["target"] == {"at": {"order": 20, "time": scene.poses["time"][20]}}
    T = sensor_frames(scene.workcell.arm, scene.q)
    motion = np.linalg.inv(T) @ scene.T_base_sensor  # in the old sensor's frame
    np.testing.assert_allclose(motion[:20], np.tile(np.eye(4), (20, 1, 1)), **EXACT)
    np.testing.assert_allclose(motion[20:], np.tile(motion[20], (len(T) - 20, 1, 1)), **EXACT)
    assert np.linalg.norm(motion[20, :3, 3]) == pytest.approx(3e-3, abs=1e-12)
    turn = Rotation.from_matrix(motion[20, :3, :3]).as_rotvec()
    np.testing.assert_allclose(turn, entry["turn_rad"], **EXACT)
    assert np.linalg.norm(turn) == pytest.approx(3e-3, abs=1e-12)
    table = scene.truth_poses
    after = sensor_frames(scene.workcell.arm, angles_in(table, 6)) @ motion[20]
    np.testing.assert_allclose(table[["x", "y", "z"]].to_numpy(), after[:, :3, 3], **EXACT)


def test_a_sensor_oscillates_along_one_line():
    """The sensor leaves its place by a sine of the recorded time, and is at rest at the evaluation poses."""
    scene = injected({"effect": "unknown", "kind": "sensor_oscillation", "size": 4e-4})
    (entry,) = scene.truth["effects"]
    motion = np.linalg.inv(sensor_frames(scene.workcell.arm, scene.q)) @ scene.T_base_sensor
    time = scene.poses["time"].to_numpy() / entry["end_s"]
    swing = 4e-4 * np.sin(2 * np.pi * entry["periods"] * time + entry["phase_rad"])
    # The shift is on the flange, seen here from the sensor that is turned on it.
    R = scene.workcell.arm.T_flange_sensor[:3, :3]
    np.testing.assert_allclose(motion[:, :3, 3] @ R.T, swing[:, None] * entry["direction"], **EXACT)
    table = scene.truth_poses
    T = sensor_frames(scene.workcell.arm, angles_in(table, 6))
    np.testing.assert_allclose(table[["x", "y", "z"]].to_numpy(), T[:, :3, 3], **EXACT)


RANGES = {
    "range_scale": lambda r: 3e-3 * r,
    "range_offset": lambda r: np.full_like(r, 3e-3),
    "range_distortion": lambda r: 3e-3 * (r - 0.275) ** 2,  # between 0.1 and 0.45 m
}


@pytest.mark.parametrize("axis", ["ray", "z"])
@pytest.mark.parametrize("effect", RANGES)
def test_the_laser_errs_along_its_error_axis(effect, axis):
    """A laser errs along the ray as a function of its range; a profiler errs along z, and its x is exact."""
    sensor = {"pose": {"translation": [0.05, 0.02, 0.1]}, "error_axis": axis}
    scene = injected({"effect": effect, "size": 3e-3}, sensor=sensor, seed=2)
    x, z = scene.ranges * np.sin(scene.angles), scene.ranges * np.cos(scene.angles)
    if axis == "z":
        expected = np.stack([x, z + RANGES[effect](z)], -1)
    else:
        stretch = 1 + RANGES[effect](scene.ranges) / scene.ranges
        expected = np.stack([x * stretch, z * stretch], -1)
    np.testing.assert_allclose(scene.points, expected, atol=1e-14)
    assert np.abs(scene.points - np.stack([x, z], -1)).max() > 1e-5
