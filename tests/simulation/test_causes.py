"""Causes of no known name: each behaves as its physics says."""

import json

import numpy as np
import pytest

from scalar.errors import InvalidInput
from scalar.simulation.injected.causes import CAUSES
from scalar.simulation.injected.causes.climate import thermostat
from scalar.simulation.injected.causes.drives import LINES
from scalar.simulation.injected.causes.hose import relaxed
from scalar.simulation.injected.causes.mount import FRICTION, sides
from scalar.simulation.injected.causes.moves import amplitude, lag
from tests.simulation.injecting import angles_in, injected

SIZE = 3e-4
AT_REST_NOTHING = ("late_trigger", "vibration", "wandering_laser")


def entry_of(kind, **more):
    """Return an entry of `injected`."""
    return {"effect": "unknown", "kind": kind, "size": SIZE} | more


@pytest.fixture(scope="module")
def control():
    """Return the scene without."""
    return injected()


def joint_errors(scene, control):
    """Return what the effect does to the joints (N, n) [rad], asked of the effect with the arm in the engine."""
    from scalar.simulation.world import World

    with World() as world:
        world.place_arm(scene.workcell.arm)
        return scene.effects.joint_errors(world, control.q, scene.poses)


@pytest.mark.parametrize("kind", CAUSES)
def test_a_cause_acts_and_the_truth_names_it(kind, control):
    """Scans differ from the control's, encoders read the same, the truth holds the cause's kind as JSON, and the bytes are the same twice."""
    scene = injected(entry_of(kind))
    (truth,) = json.loads(json.dumps(scene.truth, allow_nan=False))["effects"]
    assert (truth["name"], truth["kind"]) == ("unknown", kind) and truth["depends_on"]
    assert np.abs(scene.points - control.points).max() > 1e-6
    assert injected(entry_of(kind)).scans.equals(scene.scans)
    np.testing.assert_array_equal(angles_in(scene.poses, 6), angles_in(control.poses, 6))


@pytest.mark.parametrize("kind", CAUSES)
def test_a_cause_is_in_proportion_to_its_size(kind, control):
    """A hundredth of the size has a hundredth of the effect, to the square of small errors, and a size of zero has none."""
    large = injected(entry_of(kind)).points - control.points
    small = injected(entry_of(kind, size=SIZE / 100)).points - control.points
    np.testing.assert_allclose(small * 100, large, atol=0.02 * np.abs(large).max())


@pytest.mark.parametrize("kind", CAUSES)
def test_at_rest_only_what_the_pose_itself_does_is_left(kind, control):
    """Evaluation poses are reached one by one: effects of moves are absent, and those of weight and angles are present."""
    moved = np.abs(injected(entry_of(kind)).truth_poses - control.truth_poses).to_numpy().max()
    assert (moved == 0) == (kind in AT_REST_NOTHING)


@pytest.mark.parametrize("kind", ["two_pulley_belt", "encoder_interpolation", "two_slope_gear", "vibration"])
def test_a_drive_errs_in_its_own_joint_by_its_size(kind, control):
    """One joint alone errs, at most by the size, and somewhere by all of it."""
    dq = joint_errors(injected(entry_of(kind, target={"joint": 3})), control)
    assert not np.delete(dq, 2, axis=1).any()
    assert np.abs(dq[:, 2]).max() == pytest.approx(SIZE)


def test_a_hose_depends_on_the_way_to_a_posture(control):
    """The same posture errs differently after another way, and not after the hose has hung there for hours."""
    length, time = np.array([1.0, 2.0, 1.0, 1.0, 1.0]), np.array([0.0, 10.0, 20.0, 30.0, 36000.0])
    remembered = relaxed(length, time, 60.0)
    assert remembered[2] > remembered[0] and remembered[2] > remembered[3] > 1.0
    assert remembered[4] == pytest.approx(1.0)
    scene = injected(entry_of("hose"))
    dq = joint_errors(scene, control)
    still = joint_errors(injected(entry_of("hose")), control)
    np.testing.assert_array_equal(dq, still)
    rested = scene.effects.at_rest()
    from scalar.simulation.world import World

    with World() as world:
        world.place_arm(scene.workcell.arm)
        settled = rested.joint_errors(world, control.q, scene.poses)
    assert np.abs(dq - settled).max() > 0.05 * SIZE


def test_a_hose_pulls_towards_its_anchor(control):
    """Where the hose is taut, the arm gives way so that the distance to the anchor shrinks."""
    from scalar.simulation.world import World

    scene = injected(entry_of("hose", size=1e-3))
    rested, arm = scene.effects.at_rest(), scene.workcell.arm
    with World() as world:
        world.place_arm(arm)
        dq = rested.joint_errors(world, control.q, scene.poses)
    anchor = np.array(scene.truth["effects"][0]["anchor_m"])
    before = np.linalg.norm(arm.sensor_frames(control.q)[1] - anchor, axis=1)
    after = np.linalg.norm(arm.sensor_frames(control.q + dq)[1] - anchor, axis=1)
    taut = np.abs(dq).max(1) > 0
    assert 0 < taut.sum() < len(taut)
    assert (after[taut] < before[taut]).all()


def test_the_encoder_repeats_512_times_a_turn():
    """A step of a line leaves its error, half a step does not; sampled at whole lines it is aliased to a constant."""
    from scalar.simulation.world import World

    scene = injected(entry_of("encoder_interpolation", target={"joint": 2}))
    pitch = 2 * np.pi / LINES
    q = np.zeros((400, scene.q.shape[1]))
    q[:, 1] = np.linspace(0, pitch, 400, endpoint=False)
    with World() as world:
        world.place_arm(scene.workcell.arm)
        first, line_on, half_on = (
            scene.effects.joint_errors(world, q + shift, scene.poses)[:, 1]
            for shift in (0, 7 * pitch, pitch / 2)
        )
        q[:, 1] = np.arange(400) * pitch
        aliased = scene.effects.joint_errors(world, q, scene.poses)[:, 1]
    np.testing.assert_allclose(first, line_on, atol=1e-12)
    assert np.abs(first - half_on).max() > 0.1 * SIZE
    assert np.ptp(aliased) < 1e-12 < np.ptp(first)


def test_a_belt_repeats_with_its_pulleys_and_not_with_the_joint(control):
    """The error has two frequencies, neither of which is a whole number of times a turn."""
    truth = injected(entry_of("two_pulley_belt")).truth["effects"][0]
    for turns in (truth["turns"], truth["turns"] * truth["ratio"]):
        assert turns > 1
    assert abs(truth["turns"] - round(truth["turns"])) > 0.1
    assert abs(truth["ratio"] - round(truth["ratio"])) > 0.1


def test_a_gear_is_softer_below_its_bend(control):
    """The wind-up is odd in the torque, with one slope up to the bend and a smaller one beyond."""
    from scalar.simulation.world import World

    scene = injected(entry_of("two_slope_gear", target={"joint": 2}))
    truth = scene.truth["effects"][0]
    dq = joint_errors(scene, control)[:, 1]
    with World() as world:
        world.place_arm(scene.workcell.arm)
        torque = world.gravity_torques(control.q)[:, 1]
    below = np.abs(torque) < truth["bend_n_m"]
    slope = dq[below] / torque[below]
    np.testing.assert_allclose(slope, slope[0], rtol=1e-9)
    assert (np.abs(dq[~below]) < slope[0] * np.abs(torque[~below]) + 1e-15).all() and (~below).any()
    assert (np.sign(dq) == np.sign(torque)).all()


def test_a_mount_flops_with_hysteresis():
    """The mount stays on its side while the pull to the other is weaker than friction, and changes only then."""
    pull = np.array([1.0, 0.1, -0.5 * FRICTION, -2 * FRICTION, 0.5 * FRICTION, 2 * FRICTION])
    np.testing.assert_array_equal(sides(pull), [1, 1, 1, -1, -1, 1])
    scene = injected(entry_of("loose_mount"))
    states = scene.effects.parts[0].states
    assert set(np.unique(states)) == {-1.0, 1.0}


def test_a_resonance_peaks_and_turns_its_phase():
    """A driven oscillator is at rest for zero frequency, and peaks near its own frequency. Its phase turns by a quarter there, and by half beyond."""
    r = np.linspace(0.0, 20.0, 20_001)
    assert amplitude(r)[0] == 0 and amplitude(r)[-1] == pytest.approx(1.0, abs=0.01)
    assert r[np.argmax(amplitude(r))] == pytest.approx(1.0, abs=0.05)
    np.testing.assert_allclose(lag(np.array([0.0, 1.0, 1e4])), [0.0, np.pi / 2, np.pi], atol=1e-3)


def test_a_late_trigger_moves_along_the_velocity(control):
    """Every joint errs by its own velocity times one delay, give or take a tenth."""
    dq = joint_errors(injected(entry_of("late_trigger")), control)
    velocity = np.gradient(control.q, axis=0) / np.gradient(control.poses["time"].to_numpy())[:, None]
    delays = dq / velocity
    np.testing.assert_allclose(delays, delays[:, :1].repeat(6, axis=1), rtol=1e-9)
    assert (np.sign(delays) == np.sign(delays[0, 0])).all()
    assert delays[:, 0].std() < 0.3 * abs(delays[:, 0].mean())


def test_air_conditioning_swings_about_the_middle_and_lags():
    """The temperature is periodic, stays between the limits of heating and cooling, and swings less for a slow arm."""
    time = np.arange(0.0, 8000.0, 10.0)
    quick, slow = thermostat(time, 300.0, 100.0, 1500.0), thermostat(time, 300.0, 900.0, 1500.0)
    assert np.abs(quick).max() < 1.0
    assert np.ptp(slow[400:]) < 0.7 * np.ptp(quick[400:])
    crossings = np.flatnonzero(np.diff(np.sign(quick - quick.mean())) > 0)
    assert len(crossings) >= 4 and np.ptp(np.diff(crossings)) <= 2


def test_growth_falls_back_after_each_period():
    """The growth is a sawtooth of about 45 poses: it rises evenly and falls back at once."""
    scene = injected(entry_of("sawtooth_growth"), poses_per_plane=40, seed=3)
    states, period = scene.effects.parts[0].states, scene.truth["effects"][0]["period_poses"]
    assert 42 <= period <= 48
    steps = np.diff(states)
    falls = np.flatnonzero(steps < 0)
    assert (np.diff(falls) == period).all() and len(falls) >= 2
    np.testing.assert_allclose(steps[steps > 0], SIZE / (period - 1), rtol=1e-9)


def test_the_floor_holds_until_it_gives_way(control):
    """Below the anchors' preload the base does not move, and beyond it tilts as the moment turns."""
    from scalar.simulation.world import World

    scene = injected(entry_of("giving_floor"))
    with World() as world:
        world.place_arm(scene.workcell.arm)
        moments = world.weight_moments(control.q, np.zeros(3))
        motions = scene.effects.motions(world, control.q, scene.poses)
    moved = np.abs(motions - np.eye(4)).max((1, 2)) > 0
    beyond = np.linalg.norm(moments, axis=1) > scene.truth["effects"][0]["holds_n_m"]
    np.testing.assert_array_equal(moved, beyond)
    turned = np.stack([motions[:, 2, 1], motions[:, 0, 2], motions[:, 1, 0]], -1)
    assert (np.einsum("ni,ni->n", turned, moments)[beyond] > 0).all()


def test_a_laser_that_wanders_turns_its_plane_and_misreads(control):
    """The frame turns about the scanner's x axis alone, by no more than the size."""
    scene = injected(entry_of("wandering_laser"))
    turn = np.linalg.inv(control.T_base_sensor) @ scene.T_base_sensor
    np.testing.assert_allclose(turn[:, :3, 3], 0.0, atol=1e-12)
    angle = np.arcsin(turn[:, 2, 1])
    assert np.abs(angle).max() == pytest.approx(SIZE, rel=1e-6)
    reading = np.linalg.norm(scene.points, axis=2) - scene.ranges
    assert np.abs(reading).max() > 1e-6


def test_a_joint_where_there_is_none_is_refused():
    """A cause of the whole arm takes no joint, and a message names the cause for which one was stated."""
    from scalar.errors import InvalidInput

    with pytest.raises(InvalidInput, match="'hose' has no joint"):
        injected(entry_of("hose", target={"joint": 2}))


@pytest.mark.parametrize("joint", [2, 3])
def test_a_spring_turns_its_joint_towards_less_energy(joint, control):
    """The joint errs against the slope of the spring's energy over its angle, by the size at most, and other joints stand; both angles matter."""
    scene = injected(entry_of("forearm_spring", target={"joint": joint}))
    (truth,) = scene.truth["effects"]

    def energy(q):
        """Return (L - L0)^2 / 2 by complex numbers: the elbow at exp(i q2), the mount m exp(i (q2 + q3)) beyond it."""
        mount = np.exp(1j * q[:, 1]) + truth["mount"] * np.exp(1j * (q[:, 1] + q[:, 2]))
        return (np.abs(mount - complex(*truth["anchor"])) - truth["neutral"]) ** 2 / 2

    step = 1e-5 * np.eye(6)[joint - 1]
    slope = (energy(control.q + step) - energy(control.q - step)) / 2e-5
    dq = joint_errors(scene, control)
    np.testing.assert_allclose(dq[:, joint - 1], -SIZE * slope / np.abs(slope).max(), atol=1e-8)
    assert not np.delete(dq, joint - 1, axis=1).any()
    for angle in (1, 2):
        turned = control.q + 0.3 * np.eye(6)[angle]
        assert np.abs(energy(turned + step) - energy(turned - step) - 2e-5 * slope).max() > 1e-6


def test_a_spring_loads_shoulder_and_elbow_only():
    """Another joint is refused with the two that a spring of the forearm loads."""
    with pytest.raises(InvalidInput, match="joints 2 and 3"):
        injected(entry_of("forearm_spring", target={"joint": 5}))
