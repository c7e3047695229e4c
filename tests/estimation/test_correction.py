"""Corrected joint angles: `predict` takes them to where the nominal arm would be, whatever effects act."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from scalar.data.io.plain_yaml import load_yaml
from scalar.data.poses import Poses
from scalar.effects.base_compliance import BaseCompliance
from scalar.effects.joint_backlash import JointBacklash
from scalar.effects.joint_compliance import JointCompliance
from scalar.effects.joint_harmonic import JointHarmonic
from scalar.effects.pose_lag import PoseLag
from scalar.effects.sensor_slip import SensorSlip
from scalar.effects.thermal_drift import ThermalDrift
from scalar.errors import InvalidInput
from scalar.estimation.correction import correct_frames, correct_joints, postures_for, sensitivity
from scalar.export.rigid_part import rigid_part
from scalar.export.urdf import put_calibration, text_of
from scalar.geometry.robot import Robot
from scalar.ingest.urdf import chain_between, read_urdf, robot_from_urdf
from tests.calibrated_arms import T_SENSOR, calibrated
from tests.robot_configs import ROBOT_CONFIGS
from tests.robot_descriptions import ARMS, kinematics_alone, poses_by_pybullet, shipped
from tests.turning import turning


def robot_of(name):
    """Return the arm of a file of configs/robots."""
    return Robot.from_mapping(load_yaml(ROBOT_CONFIGS / f"{name}.yaml"))


def first_joints(n):
    """Return the first joints of the VS060 as an arm."""
    robot = robot_of("vs060")
    return replace(robot, geometry=robot.geometry[:, :n], limits=robot.limits[:n])


def everything(n, rng):
    """Return one effect of each place and dependence, of the size that real arms have."""
    pairs = tuple((j, f) for j in range(1, n + 1) for f in range(j, n + 1))
    return (
        JointCompliance(pairs, coefficients=1e-4 * rng.normal(size=2 * len(pairs))),
        *(JointHarmonic(j, (1, 4), coefficients=2e-4 * rng.normal(size=4)) for j in range(1, n + 1)),
        JointBacklash(2, "approach", coefficients=np.array([3e-4])),
        ThermalDrift("temperature", 20.0, coefficients=np.array([2e-5])),
        BaseCompliance((1, 2, 3), True, coefficients=2e-4 * rng.normal(size=6)),
        SensorSlip(5.0, coefficients=1e-3 * rng.normal(size=6)),
    )


def regular(model, q):
    """Return the poses that are not near a singularity: everywhere else a correction has to be found."""
    return q[~correct_joints(model, Poses.from_arrays(q, {}, turning(q.shape[1]))).near_singular]


@pytest.mark.parametrize("name", ["vs060", "ur10e", "panda", "small_arm"])
def test_predict_at_corrected_joints_is_where_the_nominal_arm_would_be(name):
    """For six joints and seven, with effects on joints, links, base and sensor, the frames agree to 1e-6 m and 1e-6 rad."""
    rng = np.random.default_rng(1)
    robot = robot_of(name)
    n = robot.n_joints
    calibration = calibrated(robot, rng, everything(n, rng), size=0.3)
    low, high = robot.limits.T
    rigid = replace(calibration.model, effects=())
    q = regular(rigid, rng.uniform(low, high, (300, n)))
    columns = {
        "temperature": rng.uniform(15, 35, len(q)),
        "approach": rng.choice([-1.0, 1.0], q.shape),
        "order": rng.integers(0, 10, len(q)).astype(float),
    }
    found = correct_joints(calibration.model, Poses.from_arrays(q, columns, turning(n)))
    assert (
        found.reached.mean() > 0.98
    )  # the edge of the reach is no singularity of the posture, and may be passed
    there = found.reached
    kept = {name: values[there] for name, values in columns.items()}
    T = calibration.predict(calibration.correct(q[there], **kept), **kept)
    slip = calibration.model.effects[-1].coefficients
    after = kept["order"] >= 5.0
    wanted = robot.flange(q[there]) @ T_SENSOR
    np.testing.assert_allclose(T[~after], wanted[~after], atol=1e-6, rtol=0)
    shifted = (
        wanted[after, :3, 3] + wanted[after, :3, :3] @ slip[:3]
    )  # the sensor slipped: the flange is what is put right
    np.testing.assert_allclose(T[after, :3, 3], shifted, atol=1e-6, rtol=0)


def test_an_arm_as_its_maker_drew_it_needs_no_correction():
    """With the nominal geometry and no effect, joint angles stay what they are."""
    robot = robot_of("vs060")
    calibration = calibrated(robot, np.random.default_rng(1), size=0.0)
    q = np.random.default_rng(2).uniform(-1, 1, (50, 6))
    np.testing.assert_allclose(calibration.correct(q), q, atol=1e-12)


def test_pybullet_takes_the_calibrated_arm_to_the_nominal_place(tmp_path):
    """In pybullet, the exported description at corrected angles is where the nominal description is at the nominal angles."""
    pytest.importorskip("pybullet_data")
    path, (_, base, tip) = shipped("xarm6"), ARMS["xarm6"]
    robot, _ = robot_from_urdf(path, base, tip)
    calibration = calibrated(robot, np.random.default_rng(1))
    document = read_urdf(path)
    put_calibration(document, base, tip, robot, rigid_part(calibration.model, {}), "scalar_sensor")
    made = tmp_path / "made.urdf"
    made.write_text(text_of(document, "c"), encoding="utf-8")
    joints = [joint.name for joint in chain_between(document, base, tip).moving]
    low, high = robot.limits.T
    rng = np.random.default_rng(3)
    q = regular(calibration.model, rng.uniform(np.maximum(low, -2), np.minimum(high, 2), (60, 6)))
    found = correct_joints(calibration.model, Poses.from_arrays(q, {}, turning(6)))
    q, corrected = q[found.reached], found.q[found.reached]
    assert len(q) > 20
    before = kinematics_alone(path, tmp_path / "before.urdf")
    after = kinematics_alone(made, tmp_path / "after.urdf")
    nominal = poses_by_pybullet(before, base, tip, q, joints) @ T_SENSOR
    real = poses_by_pybullet(after, base, "scalar_sensor", corrected, joints)
    np.testing.assert_allclose(real, nominal, atol=1e-6, rtol=0)


def test_a_wrist_that_is_stretched_is_said_to_be_singular():
    """With the axes of joints 4 and 6 in one line, the pose is near a singularity; nothing that is called reached is off."""
    rng = np.random.default_rng(1)
    robot = robot_of("vs060")
    calibration = calibrated(robot, rng)
    q = rng.uniform(-1, 1, (50, 6))
    q[:25, 4] = rng.choice([0.0, 1e-12, 1e-4], 25)
    q[25:, 4] = 1.0
    q[:, 2] = 1.2
    found = correct_joints(calibration.model, Poses.from_arrays(q, {}, turning(6)))
    assert found.near_singular[:25].all() and found.near_singular[25:].mean() < 0.2
    T = calibration.predict(found.q)
    off = np.linalg.norm((T - found.T_wanted)[:, :3, 3], axis=1)
    assert off[found.reached].max() < 1e-6
    np.testing.assert_allclose(off, found.position_error, atol=1e-12)
    assert np.isfinite(found.q).all()


def test_a_frame_that_is_not_reached_is_not_called_reached():
    """Frames beyond the reach, and frames where an effect jumps, are not called reached unless they are."""
    robot = robot_of("vs060")
    calibration = calibrated(robot, np.random.default_rng(1))
    q = np.zeros((3, 6)) + 0.5
    T = calibration.predict(q)
    T[1, :3, 3] *= 4.0
    found = correct_frames(calibration.model, Poses.from_arrays(q, {}, turning(6)), T)
    assert found.reached.tolist() == [True, False, True]
    assert found.position_error[1] > 0.1
    stretched = robot.with_geometry(robot.geometry * np.array([1.05, 1, 1, 1, 1])[:, None])
    short = replace(calibration, model=replace(calibration.model, nominal=stretched))
    assert len(repr(short)) < 300 and "residual" in repr(short)
    with pytest.raises(
        InvalidInput, match=r"row 2: .*cannot take this pose.* nor 1 more; leave such rows out"
    ):
        short.correct(
            np.array([[0.0, 0.4, 1.2, 0.1, 0.6, 0.2], *np.zeros((2, 6))])
        )  # upright, with the nominal arm longer than the real one


def test_joints_beyond_their_limits_are_marked():
    """Joints that a correction takes beyond their limits are marked, and no others."""
    robot = robot_of("vs060")
    calibration = calibrated(robot, np.random.default_rng(1))
    q = np.random.default_rng(2).uniform(-1, 1, (40, 6))
    found = correct_joints(calibration.model, Poses.from_arrays(q, {}, turning(6)))
    tight = np.column_stack([np.full(6, -2.0), np.sort(found.q, axis=0)[19]])
    limited = replace(calibration.model, robot=replace(calibration.model.robot, limits=tight))
    again = correct_joints(limited, Poses.from_arrays(q, {}, turning(6)))
    np.testing.assert_array_equal(again.beyond_limits, found.q > tight[:, 1])


@pytest.mark.parametrize("name", ["vs060", "ur10e", "panda"])
def test_postures_are_found_for_frames_alone(name):
    """For a frame made by any posture, a posture within the limits is found that takes it."""
    rng = np.random.default_rng(1)
    robot = robot_of(name)
    calibration = calibrated(robot, rng)
    low, high = robot.limits.T
    T = calibration.predict(regular(calibration.model, rng.uniform(low, high, (120, robot.n_joints))))
    q, there = postures_for(calibration.model, T)
    assert there.mean() > 0.95
    assert np.all((q[there] >= low) & (q[there] <= high))
    np.testing.assert_allclose(calibration.predict(q[there]), T[there], atol=1e-6, rtol=0)
    near = q[~there & ~np.isnan(q[:, 0])]
    assert np.all((near >= low) & (near <= high))


def test_joints_do_not_wind_up_over_a_program():
    """A joint that may turn more than once comes back to the middle of its limits in a large move, and goes on over half a turn in a small one."""
    robot = first_joints(6)
    model = calibrated(
        replace(robot, limits=np.tile([-2 * np.pi, 2 * np.pi], (6, 1))), np.random.default_rng(6)
    ).model
    q = np.random.default_rng(7).uniform(-1.5, 1.5, (40, 6))
    found, there = postures_for(model, model.robot.flange(q) @ model.T_flange_sensor)
    far = np.abs(np.diff(found, axis=0)) > np.pi / 2
    assert there.all() and far.any()
    assert np.abs(found[1:][far]).max() < np.pi + 1e-9
    path = np.tile([0.2, -0.4, 1.2, 0.3, 0.9, np.deg2rad(170.0)], (2, 1))
    path[1, [0, 5]] = 2.0, np.deg2rad(190.0)  # a large move of joint 1 alone
    found, there = postures_for(model, model.robot.flange(path) @ model.T_flange_sensor, first=path[0])
    assert there.all() and abs(found[1, 5] - found[0, 5]) < np.pi / 2


def test_a_path_stays_in_one_posture():
    """Frames along a smooth path get joint angles along a smooth path, without a change of posture."""
    rng = np.random.default_rng(1)
    calibration = calibrated(robot_of("vs060"), rng)
    share = np.linspace(0, 1, 60)[:, None]
    path = np.array([0.2, 0.3, 1.0, 0.2, 0.7, 0.1]) + share * np.array([0.6, 0.2, 0.3, -0.3, 0.4, 0.5])
    q, there = postures_for(calibration.model, calibration.predict(path))
    assert there.all()
    assert np.abs(np.diff(q, axis=0)).max() < 0.1


def test_a_program_of_moderate_moves_keeps_the_posture_of_the_row_before():
    """No frame of a program whose joints move by up to 0.6 rad gets a posture to which they move farther: the wrist does not turn over."""
    model = calibrated(robot_of("vs060"), np.random.default_rng(1)).model
    rng = np.random.default_rng(2)
    middle = np.array([0.2, 0.3, 1.2, 0.2, 0.9, 0.1])
    program = [middle]
    while len(program) < 60:
        q = program[-1] + rng.uniform(-0.6, 0.6, 6)
        if np.all(np.abs(q - middle) < 0.7):  # stays on one side of all singularities
            program.append(q)
    q, there = postures_for(
        model, model.robot.flange(np.array(program)) @ model.T_flange_sensor, first=program[0]
    )
    assert there.all()
    np.testing.assert_allclose(q, program, atol=1e-4)


def test_a_column_that_an_effect_needs_is_named():
    """Without the directions of approach, backlash by approach cannot be corrected."""
    effect = JointBacklash(3, "approach", coefficients=np.array([3e-4]))
    calibration = calibrated(robot_of("vs060"), np.random.default_rng(1), (effect,))
    with pytest.raises(InvalidInput, match="approach3"):
        calibration.correct(np.zeros((2, 6)))


def test_a_lag_follows_the_moves_between_corrected_poses():
    """If the order states the moves, `predict` computes them from the corrected angles, and a lag acts on these."""
    rng = np.random.default_rng(1)
    robot = robot_of("vs060")
    lags = tuple(PoseLag(j, coefficients=np.array([5e-3])) for j in (1, 4))
    play = JointBacklash(2, "moves", coefficients=np.array([3e-4]))
    calibration = calibrated(robot, rng, (*lags, play))
    q = rng.uniform(-1, 1, (40, 6))
    q[:, 2], q[:, 4] = rng.uniform(0.8, 1.6, 40), rng.uniform(0.4, 1.2, 40)
    table = pd.DataFrame(q, columns=[f"q{i + 1}" for i in range(6)]).assign(order=np.arange(40.0))
    corrected = table.assign(**dict(zip(table.columns[:6], calibration.correct(table).T, strict=True)))
    off = calibration.predict(corrected) - robot.flange(q) @ T_SENSOR
    assert np.abs(off[:, :3, 3]).max() < 1e-6


def test_the_sensitivity_is_how_far_joints_move_for_a_small_shift():
    """Corrections for shifts by 0.01 mm in many directions move each joint by at most the stated travel, and in one direction by that much.

    The stated singular value is small near a singular pose.
    """
    model = calibrated(robot_of("vs060"), np.random.default_rng(4)).model
    q = np.array([0.3, 0.2, 1.2, 0.4, 0.8, -0.5])
    directions = np.random.default_rng(5).standard_normal((2000, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    poses = Poses.from_arrays(np.tile(q, (len(directions), 1)), {}, turning(6))
    wanted = model.robot.flange(poses.q) @ model.T_flange_sensor
    shift = 1e-5
    wanted[:, :3, 3] += shift * directions
    found = correct_frames(model, poses, wanted)
    moved = np.abs(found.q - q).max(axis=0) / shift
    near = sensitivity(model, Poses.from_arrays(q[None], {}, turning(6)), q[None])
    np.testing.assert_allclose(moved, near.travel[0], rtol=0.02)
    straight = q.copy()
    straight[4] = 0.0
    both = np.stack([q, straight])
    values = sensitivity(model, Poses.from_arrays(both, {}, turning(6)), both).singular_value
    assert values[1] < 0.02 < values[0]
