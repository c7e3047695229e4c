"""Injected errors of the joints: the arm stands where SciPy's kinematics puts it at q + dq, dq by hand."""

from dataclasses import replace

import numpy as np
import pytest

from scalar.simulation import SimulatedScene
from scalar.simulation.arm import arm_from_mapping
from scalar.simulation.injected.compliance import JointCompliance
from scalar.simulation.injected.moves import stretched
from scalar.simulation.weights import Weights
from scalar.simulation.world import World
from tests.simulation.geometry import masses_at, sensor_frames
from tests.simulation.injecting import angles_in, injected

EXACT = {"atol": 1e-12, "rtol": 0}


def assert_stands_at(scene: SimulatedScene, error) -> None:
    """Assert that scans and evaluation poses are those of an arm at q + error(q, poses)."""
    arm = scene.workcell.arm
    dq = error(scene.q, scene.poses)
    assert np.abs(dq).max() > 1e-5
    np.testing.assert_allclose(scene.T_base_sensor, sensor_frames(arm, scene.q + dq), **EXACT)
    table = scene.truth_poses
    q = angles_in(table, arm.n)
    T = sensor_frames(arm, q + error(q, table))
    np.testing.assert_allclose(table[["x", "y", "z"]].to_numpy(), T[:, :3, 3], **EXACT)


def on_joint(joint, function):
    """Return an error of one joint, from 1, as a function of q and poses."""

    def error(q, poses):
        dq = np.zeros_like(q)
        dq[:, joint - 1] = function(q[:, joint - 1], q, poses)
        return dq

    return error


def test_a_harmonic_is_a_sine_of_the_angle():
    """The named joint alone errs, by dq = size sin(order q + phase)."""
    entry = {
        "effect": "joint_harmonic",
        "target": {"joint": 4, "order": 5},
        "size": 4e-4,
        "phases_rad": [0.7],
    }
    assert_stands_at(injected(entry), on_joint(4, lambda angle, *_: 4e-4 * np.sin(5 * angle + 0.7)))


def test_harmonics_of_one_joint_add_up():
    """Several orders are one entry; each has the size as its amplitude and a phase of its own."""
    scene = injected({"effect": "joint_harmonic", "target": {"joint": 2, "orders": [1, 8]}, "size": 3e-4})
    (entry,) = scene.truth["effects"]
    assert entry["target"] == {"joint": 2, "orders": [1, 8]}
    one, eight = entry["phases_rad"]
    assert_stands_at(
        scene, on_joint(2, lambda angle, *_: 3e-4 * (np.sin(angle + one) + np.sin(8 * angle + eight)))
    )


def test_a_scale_is_in_proportion_to_the_angle():
    """The joint errs by dq = size q."""
    scene = injected({"effect": "joint_scale", "target": {"joint": 3}, "size": -2e-3})
    assert_stands_at(scene, on_joint(3, lambda angle, *_: -2e-3 * angle))


def test_a_coupling_is_in_proportion_to_its_source():
    """Joint 6 errs by dq_6 = size q_5."""
    scene = injected({"effect": "joint_coupling", "target": {"joint": 6, "source": 5}, "size": 1e-3})
    assert_stands_at(scene, on_joint(6, lambda _, q, __: 1e-3 * q[:, 4]))


def test_play_goes_to_the_side_from_which_the_joint_came():
    """The joint errs by dq = size times the recorded direction of approach, at the evaluation poses too."""
    scene = injected({"effect": "joint_backlash", "target": {"joint": 2}, "size": 3e-4})
    assert set(scene.poses["approach2"]) == set(scene.truth_poses["approach2"]) == {-1, 1}
    assert_stands_at(scene, on_joint(2, lambda _, __, poses: 3e-4 * poses["approach2"].to_numpy()))


def energies(arm, q):
    """Return the potential energy of the arm's masses (N,) [J]."""
    where, masses = masses_at(arm, q)
    return -np.einsum("l,nli,i->n", masses, where, arm.gravity)


def torques(arm, q, step=1e-4):
    """Return minus the gradient of the energy over the angles, (N, n) [N m]."""
    columns = []
    for j in range(q.shape[1]):
        d = np.zeros(q.shape[1])
        d[j] = step
        columns.append(-(energies(arm, q + d) - energies(arm, q - d)) / (2 * step))
    return np.column_stack(columns)


def test_play_without_a_recorded_direction_follows_the_weight():
    """With recorded: false the joint rests where its weight pulls it, by the sign of the slope of the potential energy."""
    scene = injected(
        {"effect": "joint_backlash", "target": {"joint": 2}, "size": 3e-4, "recorded": False}, record=[]
    )
    assert "approach2" not in scene.poses
    arm = scene.workcell.arm
    assert_stands_at(scene, on_joint(2, lambda _, q, __: 3e-4 * np.sign(torques(arm, q)[:, 1])))


PENDULUM = {
    "name": "pendulum",
    "convention": "modified-dh",
    "joints": [{"a": 0.0, "alpha": np.pi / 2, "d": 0.0, "theta": 0.0}],  # about -y: q lifts the rod
}


def test_a_pendulum_sags_by_its_lever():
    """A mass m on a rod of length l sags by c m g l cos q, and a mass at its end adds its own share."""
    arm = arm_from_mapping(PENDULUM, {"translation": [0.5, 0.0, 0.0]})
    arm = replace(arm, weights=Weights(np.array([7.0]), np.array([[0.3, 0.0, 0.0]]), 2.0))
    effect = JointCompliance({"joints": [1]}, 1e-5, {})
    q = np.linspace(-2.0, 2.0, 9)[:, None]
    with World() as world:
        world.place_arm(arm)
        sag = effect.joint_errors(world, q, None)
    np.testing.assert_allclose(sag, -1e-5 * 9.81 * (7.0 * 0.3 + 2.0 * 0.5) * np.cos(q), atol=1e-16)


@pytest.mark.parametrize("scene", ["ur10e", "panda"])
def test_joints_give_way_down_the_slope_of_the_energy(scene):
    """Named joints err by dq = -c dV/dq, where V is the energy of the masses at the places that SciPy's kinematics gives."""
    simulated = injected(
        {"effect": "joint_compliance", "target": {"joints": [2, 4]}, "size": 2e-5}, scene=scene
    )
    arm = simulated.workcell.arm
    dq = 2e-5 * torques(arm, simulated.q) * np.isin(np.arange(arm.n) + 1, [2, 4])
    np.testing.assert_allclose(
        simulated.T_base_sensor, sensor_frames(arm, simulated.q + dq), atol=1e-10, rtol=0
    )
    (entry,) = simulated.truth["effects"]
    for joint in (2, 4):
        largest = np.abs(dq[:, joint - 1]).max()
        assert entry["largest_deflection_rad"][f"joint{joint}"] == pytest.approx(largest, rel=1e-6)


def test_all_joints_that_carry_weight_give_way_where_none_is_named():
    """If no joint is named, all give way except the first, since its axis is vertical and no weight acts about it."""
    (entry,) = injected({"effect": "joint_compliance"}).truth["effects"]
    assert {2, 3} <= set(entry["target"]["joints"])
    assert 1 not in entry["target"]["joints"]


def test_masses_of_the_config_are_the_arms():
    """Stated masses and centres of mass replace the guessed ones, and the others stay as they were."""
    kg = [9.0, 8.0, 7.0, 3.0, 2.0, 1.0]
    masses = {"links_kg": kg, "centres_m": [[0.1, 0.0, 0.05]] * 6, "sensor_kg": 0.0}
    entry = {"effect": "joint_compliance", "target": {"joints": [2]}}
    scene = injected(entry, masses=masses)
    assert scene.truth["effects"][0]["masses_kg"] == kg
    arm = scene.workcell.arm
    T = sensor_frames(arm, scene.q + 1e-5 * torques(arm, scene.q) * np.eye(6)[1])
    np.testing.assert_allclose(scene.T_base_sensor, T, atol=1e-10, rtol=0)


def test_an_arm_that_grows_sags_under_its_own_levers():
    """If lengths drift, the torque at each pose is that of the arm at that pose.

    Pybullet keeps the dynamics of a removed arm by its address, and may take it for that of the next one.
    """
    sag = {"effect": "joint_compliance", "target": {"joints": [2]}, "size": 1e-4}
    drift = {"effect": "thermal_drift", "by": "time", "lengths": ["a_3"], "size": 5e-2}
    scene = injected(sag, drift, edge_margin_m=0.1, seed=3)
    time = scene.poses["time"].to_numpy()
    growth = 5e-2 * (time - time[0]) / (time[-1] - time[0])
    for k in range(len(time)):
        a = scene.workcell.arm.a * [1, 1, 1 + growth[k], 1, 1, 1]
        arm, q = replace(scene.workcell.arm, a=a), scene.q[k : k + 1]
        T = sensor_frames(arm, q + 1e-4 * torques(arm, q) * np.eye(6)[1])
        np.testing.assert_allclose(scene.T_base_sensor[k], T[0], atol=1e-9, rtol=0)


UNKNOWN = {
    "angle_bump": lambda e, angle, q, poses: np.exp(-0.5 * ((angle - e["place_rad"]) / e["width_rad"]) ** 2),
    "angle_step": lambda e, angle, q, poses: 1 / (1 + np.exp(-2 * (angle - e["place_rad"]) / e["width_rad"])),
    "encoder_drift": lambda e, angle, q, poses: poses["time"].to_numpy() / e["end_s"],
    "late_jump": lambda e, angle, q, poses: np.heaviside(
        poses["time"].to_numpy() - e["share"] * e["end_s"], 0.0
    ),
    "worn_teeth": lambda e, angle, q, poses: np.interp(
        np.abs(angle - e["place_rad"]) / e["width_rad"], [0.0, 0.5, 1.5, 9.0], [1.0, 1.0, 0.0, 0.0]
    ),
    "belt": lambda e, angle, q, poses: (
        2 * ((angle - e["place_rad"]) / e["width_rad"] - np.floor((angle - e["place_rad"]) / e["width_rad"]))
        - 1
    ),
    "angle_sum": lambda e, angle, q, poses: (
        np.exp(1j * (2 * q[:, e["factors"][0] - 1] + q[:, e["factors"][1] - 1])).real
    ),
}


@pytest.mark.parametrize("kind", UNKNOWN)
def test_unknown_errors_of_a_joint_have_their_shape(kind):
    """A bump, a step in the angle and a drift with time are as large as the size, at the place that the truth states."""
    scene = injected({"effect": "unknown", "kind": kind, "target": {"joint": 3}, "size": 5e-4})
    (entry,) = scene.truth["effects"]
    assert (entry["name"], entry["kind"], entry["target"]) == ("unknown", kind, {"joint": 3})
    assert_stands_at(scene, on_joint(3, lambda angle, q, p: 5e-4 * UNKNOWN[kind](entry, angle, q, p)))


def test_a_product_of_two_joints_errs_as_no_catalogue_has_it():
    """The error is largest where both factors are at an end of their ranges, and has the sign of their product."""
    scene = injected({"effect": "unknown", "kind": "angle_product", "target": {"joint": 2}, "size": 5e-4})
    (entry,) = scene.truth["effects"]
    assert entry["depends_on"] == [f"q{j}" for j in entry["factors"]]

    def shape(_, q, __):
        product = np.ones(len(q))
        for j, (low, high) in zip(entry["factors"], entry["ranges_rad"], strict=True):
            product *= (q[:, j - 1] - (low + high) / 2) / ((high - low) / 2)
        return 5e-4 * product

    assert_stands_at(scene, on_joint(2, shape))


def test_friction_winds_a_joint_up_along_a_loop():
    """From rest, one spring slips after the other: a small move and back is a closed loop, and a long move leaves all stretched."""
    slip, ways = 0.6, np.array([0.0, 0.1, -0.1, 0.1, -0.1, 2.0, 1.9, 2.0, -2.0])
    found = stretched(ways, slip / 2)
    assert found[3] == pytest.approx(found[1], abs=1e-12) and found[4] == pytest.approx(found[2], abs=1e-12)
    assert found[5] == 1.0 and found[8] == -1.0 and 0.0 < found[6] < found[7] == 1.0
    # A way back of x relaxes springs of slip s by x / s, those below x / 2 by all of it: integrals over s for many springs.
    slips = slip * (np.arange(4000) + 0.5) / 4000
    assert found[6] == pytest.approx(1.0 - np.mean(np.minimum(0.1 / slips, 2.0)), abs=0.02)
    scene = injected(
        {"effect": "joint_hysteresis", "target": {"joint": 2}, "size": 3e-4, "travel_rad": slip / 2}
    )
    error = 3e-4 * stretched(scene.q[:, 1], slip / 2)
    assert_stands_at(scene, on_joint(2, lambda angle, *_: error if len(angle) == len(error) else 0.0 * angle))
