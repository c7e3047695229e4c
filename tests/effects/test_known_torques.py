"""Joints that give way under torques that are recorded, by a simulation of its own: a payload's torque is the slope of its potential energy."""

from dataclasses import replace

import numpy as np
import pytest

from scalar.cli.calibration_words import describe_calibration
from scalar.effects.payload_deflection import PayloadDeflection
from scalar.effects.torque_compliance import TorqueCompliance
from scalar.estimation.calibrate import calibrate
from scalar.report.parameter_table import parameter_tables
from tests import kinematics
from tests.kinematics import PARAMETER_KINDS
from tests.robot_configs import robot_mapping
from tests.tracked_targets import drawn_arm

N = 40
SOFT = {2: 8e-6, 3: -5e-6}  # rad/(N m), by joint
PLACE = np.array([0.03, -0.02, 0.08])  # m, flange


def workcell(seed):
    rng = np.random.default_rng(seed)
    arm = drawn_arm(rng, ("A",))
    return arm, arm.poses(N, rng), rng


def payload_torques(arm, q, mass):
    """Return the torques ``(N, n)`` [N m] of a mass ``(N,)`` [kg] at ``PLACE``: minus the slope of its potential energy, by central differences."""
    joints = robot_mapping(arm.name)["joints"]
    nominal = np.array([[j.get(kind, 0.0) for j in joints] for kind in PARAMETER_KINDS])
    flange = kinematics.transform(robot_mapping(arm.name).get("flange"))

    def height(angles):
        return (kinematics.chain(nominal, angles) @ flange @ np.r_[PLACE, 1.0])[:, 2]

    steps = 1e-5 * np.eye(q.shape[1])
    slopes = [(height(q + step) - height(q - step)) / 2e-5 for step in steps]
    return -9.81 * mass[:, None] * np.stack(slopes, axis=1)


def measured(arm, q, rng, torques, columns):
    """Return what a tracker sees of joints that give way under torques ``(N, n)``."""
    true = q.copy()
    for joint, soft in SOFT.items():
        true[:, joint - 1] += soft * torques[:, joint - 1]
    return arm.dataset(q, rng, stated={"noise": 1e-6}, q_true=true, columns=columns)


def assert_found(calibration):
    """Assert that the compliances are those that were simulated, to a part in ten thousand, and that no residual is left."""
    (effect,) = calibration.model.effects
    found = dict(zip(effect.joints, effect.coefficients, strict=True))
    for joint, value in found.items():
        assert value == pytest.approx(SOFT.get(joint, 0.0), abs=1e-9)
    assert calibration.residual_rms < 2e-7  # what the prior of the coefficients leaves


def test_compliances_by_measured_torques_are_found():
    """Without noise, the compliances of joints under recorded torques are found, and the others are zero."""
    arm, q, rng = workcell(1)
    torques = rng.normal(0.0, 50.0, q.shape)
    columns = {f"tau{j + 1}": torques[:, j] for j in range(q.shape[1])}
    assert_found(calibrate(measured(arm, q, rng, torques, columns), effects=[TorqueCompliance((2, 3, 5))]))


def test_the_torque_of_a_payload_is_the_slope_of_its_energy():
    """The effect's torques on the nominal arm are minus the derivatives of the payload's potential energy by the joints."""
    arm, q, rng = workcell(2)
    mass = rng.choice([0.0, 4.0], N)
    columns = {"payload": mass, **dict(zip(("payload_x", "payload_y", "payload_z"), PLACE, strict=True))}
    columns = {name: np.broadcast_to(values, N) for name, values in columns.items()}
    dataset = measured(arm, q, rng, np.zeros_like(q), columns)
    torques = PayloadDeflection((1,)).torques(dataset.robot, dataset.known_poses)
    np.testing.assert_allclose(torques, payload_torques(arm, q, mass), atol=1e-6)
    assert_found(calibrate(measured(arm, q, rng, torques, columns), effects=[PayloadDeflection((2, 3, 5))]))


def test_compliances_stand_as_stiffnesses_with_their_uncertainty_too():
    """Summary, finding and table state N m/rad with the compliance's relative error.

    For a joint that shows no compliance they state a lower bound.
    """
    arm, q, rng = workcell(4)
    torques = rng.normal(0.0, 50.0, q.shape)
    columns = {f"tau{j + 1}": torques[:, j] for j in range(q.shape[1])}
    made = calibrate(measured(arm, q, rng, torques, columns), effects=[TorqueCompliance((2, 3, 5))])
    made = replace(made, covariance=np.diag(np.full(len(made.free), 4e-14)))  # 2e-7 rad/(N m)
    (effect,) = made.model.effects
    (two, three, five) = effect.stiffness([2e-7] * 3)
    assert two[1:] == pytest.approx((1 / 8e-6, 2e-7 / 8e-6**2), rel=1e-3)
    assert three[1:] == pytest.approx((1 / 5e-6, 2e-7 / 5e-6**2), rel=1e-3)
    assert np.isnan(five[1]) and five[2] == pytest.approx(1 / 4e-7, rel=1e-2)
    rows = {row[0]: row[1:] for row in effect.table([2e-7] * 3)[1]}
    assert rows["joint 2 stiffness"] == ("1.25 × 10⁵", "3125", "N m/rad")
    assert rows["joint 5 stiffness"][0].startswith("more than 2.5 × 10⁶")
    (table,) = [t for t in parameter_tables(made, None) if t["unit"] == "N m/rad"]
    assert [row["name"] for row in table["rows"]] == ["joint 2 (J2)", "joint 3 (J3)", "joint 5 (J5)"]
    said = describe_calibration(made)
    assert (
        "joint 2: stiffness 1.25e+05 +- 3.1e+03 N m/rad" in said
        and "joint 5: stiffness more than 2.5e+06" in said
    )


def test_what_is_not_recorded_is_not_looked_for():
    """Without torques, or with one payload for all poses, no such effect is proposed, and the command line says what is missing."""
    arm, q, rng = workcell(3)
    dataset = measured(arm, q, rng, np.zeros_like(q), {"payload": np.full(N, 3.0)})
    assert TorqueCompliance.candidates(dataset) == PayloadDeflection.candidates(dataset) == []
    with pytest.raises(ValueError, match="no column 'tau1'"):
        TorqueCompliance.parsed(dataset, [])
    with pytest.raises(ValueError, match="the same at all poses"):
        PayloadDeflection.parsed(dataset, [])
