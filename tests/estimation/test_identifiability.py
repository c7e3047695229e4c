"""What cannot be seen, derived for each robot and sensor: how many directions, which parameters, and in
which words.
"""

from dataclasses import replace

import numpy as np
import pytest

from scalar.errors import Undetermined
from scalar.estimation.geometry_fit import geometry_fit
from scalar.estimation.prepare import prepare
from scalar.geometry.robot import Tolerance
from tests import kinematics
from tests.kinematics import PARAMETER_KINDS
from tests.measuring_poses import ranges_to_plane
from tests.random_scene import make_scene
from tests.robot_configs import FIXED_WITH_PLANES, FIXED_WITH_PROBE, PUBLISHED_FIXED
from tests.workcell import PLANE_NAMES

PUBLISHED_COLUMNS = 39  # 24 DH, 6 of the scanner, 3 for each of three planes
ZERO = 1e-8  # of the largest singular value
FAR_FROM_ZERO = 1e-5


def identify(scene):
    """Return what is found for a scene."""
    return prepare(scene.dataset).identifiability


@pytest.mark.parametrize("upright", [True, False])
@pytest.mark.parametrize("seed", [0, 1])
def test_the_papers_setup_has_39_columns_and_7_zero_singular_values(upright, seed):
    """As in section III-C, seven singular values vanish, three decades apart from the rest; the fixed parameters are the published ones."""
    found = identify(make_scene(seed=seed, upright=upright))
    assert len(found.names) == PUBLISHED_COLUMNS == len(found.singular_values)
    assert found.singular_values[0] == pytest.approx(1.0)
    assert np.all(found.singular_values[-7:] < ZERO)
    assert np.all(found.singular_values[:-7] > FAR_FROM_ZERO)
    assert set(found.fixed_names) == set(PUBLISHED_FIXED)
    assert found.n_null == found.n_structural == 7


def test_a_null_direction_leaves_a_perfect_measurement_alone():
    """After a step along any null direction, an independent workcell scans the very same points."""
    scene = make_scene(
        noise=0.0, stated_noise=1e-4, length_error=0.0, angle_error=0.0, pose_offset=(0.0, 0.0)
    )
    found = identify(scene)
    truth, q, k = scene.truth, scene.dataset.q, scene.dataset.plane_index
    angles = np.array([-0.2, 0.0, 0.2])
    tangents = dict(zip(PLANE_NAMES, prepare(scene.dataset).initial.model.target.tangents, strict=True))

    def ranges(step):
        move = dict(zip(found.names, step, strict=True))
        geometry = truth.geometry.copy()
        for row, kind in enumerate(PARAMETER_KINDS):
            for i in range(6):
                geometry[row, i] += move.get(f"{kind}_{i + 1}", 0.0)
        T_fs = truth.T_flange_sensor.copy()
        T_fs[:3, 3] += [move[f"sensor_{axis}"] for axis in "xyz"]
        turn = np.array([move[f"sensor_r{axis}"] for axis in "xyz"])
        size = float(np.linalg.norm(turn))
        T_fs[:3, :3] = (kinematics.rotate_about(turn, size) if size > 0 else np.eye(3)) @ T_fs[:3, :3]
        normals, distances = truth.normals.copy(), truth.distances.copy()
        for j, name in enumerate(PLANE_NAMES):
            normals[j] += (
                move[f"normal_{name}_u"] * tangents[name][0] + move[f"normal_{name}_v"] * tangents[name][1]
            )
            distances[j] += move[f"distance_{name}"]
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        T = kinematics.chain(geometry, q) @ truth.T_n_flange @ T_fs
        return ranges_to_plane(T, normals[k], distances[k], angles)[0]

    h = 1e-6
    for direction in found.null_directions:
        unit = direction / np.abs(direction).max()
        slope = (ranges(h * unit) - ranges(-h * unit)) / (2 * h)
        assert np.abs(slope).max() < 1e-6
    random = np.random.default_rng(0).standard_normal(len(found.names))
    assert np.abs(ranges(h * random) - ranges(-h * random)).max() / (2 * h) > 1e-2


def test_three_parallel_axes_add_one_direction():
    """The UR10e has eight null directions, and both d_2 and d_3 are fixed."""
    found = identify(make_scene("ur10e"))
    assert found.n_null == 8
    assert set(found.fixed_names) == set(FIXED_WITH_PLANES["ur10e"])
    assert np.all(found.singular_values[:-8] > FAR_FROM_ZERO)


def test_a_seven_joint_arm_without_parallel_axes_has_six():
    """The Panda has six null directions: four of the base, two of the last joint and none between."""
    found = identify(make_scene("panda"))
    assert found.n_null == 6
    assert set(found.fixed_names) == set(FIXED_WITH_PLANES["panda"])


@pytest.mark.parametrize("robot", ["vs060", "ur10e", "panda"])
def test_a_probe_sees_neither_its_rotation_nor_the_scale(robot):
    """A probe has four more null directions than a laser: three of the sensor's rotation, and the scale of the workcell."""
    found = identify(make_scene(robot, "probe", poses_per_plane=60))
    assert {"sensor_rx", "sensor_ry", "sensor_rz"} < set(found.fixed_names)
    assert found.n_null == len(FIXED_WITH_PLANES[robot]) + 4
    by_name = {held.name: held for held in found.fixed}
    for axis in "xyz":
        assert "no residual depends on it" in by_name[f"sensor_r{axis}"].reason
    scale = [held for held in found.fixed if "may be scaled" in held.reason]
    assert [held.name for held in scale] == [FIXED_WITH_PROBE[robot]]
    assert any(name.startswith("distance_") for name in scale[0].moves_with)


@pytest.mark.parametrize("robot", ["vs060", "panda"])
def test_planes_of_known_distance_give_a_probe_the_scale_back(robot):
    """With two reference planes the scale is theirs, and no length of the arm is fixed for it."""
    scene = make_scene(robot, "probe", poses_per_plane=60)
    planes = tuple(replace(p, distance_std=1e-5, normal_std=1e-4) for p in scene.dataset.planes)
    known = replace(scene, dataset=replace(scene.dataset, planes=planes))
    found = identify(known)
    assert FIXED_WITH_PROBE[robot] not in found.fixed_names
    assert not any("may be scaled" in held.reason for held in found.fixed)


def test_a_tracker_sees_no_rotation_of_its_target():
    """A tracked point leaves the base and the sensor's rotation undetermined, and not the scale."""
    found = identify(make_scene(kind="tracker"))
    assert set(found.fixed_names) == {*PUBLISHED_FIXED, "sensor_rx", "sensor_ry", "sensor_rz"}


@pytest.mark.parametrize("joint", [2, 3, 5])
def test_a_joint_that_never_moves_is_held_and_named(joint):
    """A locked joint hides further directions; the parameters that are fixed because of it name the joint."""
    found = identify(make_scene(still_joint=joint, poses_per_plane=50, seed=1))
    because = [held for held in found.fixed if held.cause == "still"]
    assert because
    assert all(f"joint {joint} never moves" in held.reason for held in because)
    assert found.n_null > found.n_structural


def test_fifteen_poses_are_refused_by_counting():
    """The paper's 15 poses give 30 equations for 32 unknowns, however many points a scan has, and are refused."""
    for points in (10, 500):
        scene = make_scene(poses_per_plane=5, points_per_scan=points, seed=2)
        with pytest.raises(Undetermined, match="15 poses give 30 equations for 32 unknowns") as refusal:
            prepare(scene.dataset)
        assert "at least 1 more" in str(refusal.value)


@pytest.mark.parametrize("tolerance", [None, Tolerance(5e-4, 5e-4)])
def test_a_tolerance_is_asked_for_only_if_none_is_stated(tolerance):
    """With it 'scalar calibrate' fits poses that give too few equations, which the residual of a diagnosis needs."""
    dataset = make_scene(poses_per_plane=5, points_per_scan=10, seed=2).dataset
    dataset = replace(dataset, robot=replace(dataset.robot, tolerance=tolerance))
    with pytest.raises(Undetermined) as refusal:
        geometry_fit(dataset)
    assert ("or state robot.tolerance" in str(refusal.value)) == (tolerance is None)
    assert ("because robot.tolerance is stated" in str(refusal.value)) == (tolerance is not None)


def test_sixteen_poses_are_not_refused():
    """For 32 equations and 32 unknowns the fit is determined, and directions that are poorly observed stay near the data sheet."""
    scene = make_scene(poses_per_plane=6, points_per_scan=10, seed=2)
    prepared = prepare(scene.dataset.subset(np.arange(16)))
    assert prepared.free.sum() == 32
    assert {anchor.name for anchor in prepared.coarse.priors} <= set(
        np.array(prepared.initial.model.names)[prepared.free]
    )


def test_every_sentence_names_its_parameter():
    """Each fixed parameter has a complete sentence that names it."""
    found = identify(make_scene())
    assert [s.split(" is fixed: ")[0] for s in found.sentences()] == list(found.fixed_names)
    assert all(s.endswith(".") and "nan" not in s for s in found.sentences())
