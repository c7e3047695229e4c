"""The library of arms: every file is complete, agrees with what was published about the arm, and has the maker's reach."""

from math import pi
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import minimize

from scalar.data.io.plain_yaml import load_yaml
from scalar.errors import InvalidInput
from scalar.geometry.robot import Robot
from scalar.ingest.urdf import robot_from_urdf
from scalar.robots import arm_names, read_arm
from tests.robot_configs import robot_mapping

PUBLISHED = load_yaml(Path(__file__).with_name("published.yaml"))
NAMES = arm_names()


def turn(axis, angle):
    """Return rotations ``(N, 3, 3)`` about a unit vector by angles ``(N,)`` [rad] (Rodrigues)."""
    x, y, z = axis
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    s, c = np.sin(angle)[:, None, None], np.cos(angle)[:, None, None]
    return np.eye(3) + s * K + (1 - c) * (K @ K)


def moved(T, R=None, p=None):
    """Return frames ``(N, 4, 4)`` rotated by ``(N, 3, 3)`` and shifted by ``(3,)`` [m] in their own axes."""
    step = np.tile(np.eye(4), (len(T), 1, 1))
    if R is not None:
        step[:, :3, :3] = R
    if p is not None:
        step[:, :3, 3] = p
    return T @ step


def published_flange(entry, q):
    """Return the flange ``(N, 4, 4)`` that a published table gives at the library's angles ``(N, n)`` [rad]."""
    rows = entry["rows"]
    angles = np.array(entry.get("signs", [1] * len(rows))) * q
    angles = angles + np.array(entry.get("quarter_turns", [0] * len(rows))) * pi / 2
    T = np.tile(np.eye(4), (len(q), 1, 1))
    T[:, :3, 3] = entry.get("begins_at", [0.0, 0.0, 0.0])
    X, Y, Z = np.eye(3)

    def by(axis, degrees):
        return turn(axis, np.full(len(q), np.deg2rad(degrees)))

    for row, angle in zip(rows, angles.T, strict=True):
        if entry["form"] == "urdf":
            x, y, z, roll, pitch, yaw, *axis = row
            T = moved(moved(T, by(Z, yaw) @ by(Y, pitch) @ by(X, roll), (x, y, z)), turn(axis, angle))

        elif entry["form"] == "modified-dh":
            alpha, a, d, theta = row
            T = moved(moved(T, by(X, alpha)), turn(Z, angle) @ by(Z, theta), (a, 0.0, 0.0))
            T = moved(T, None, (0.0, 0.0, d))
        else:
            theta, d, a, alpha = row
            T = moved(moved(T, turn(Z, angle) @ by(Z, theta)), None, (0.0, 0.0, d))
            T = moved(moved(T, None, (a, 0.0, 0.0)), by(X, alpha))
    if "tip" in entry:
        x, y, z, roll, pitch, yaw = entry["tip"]
        T = moved(T, by(Z, yaw) @ by(Y, pitch) @ by(X, roll), (x, y, z))
    return T


def test_the_library_has_arms_and_each_was_compared():
    """At least 25 arms are verified, and ``published.yaml`` has entries for every arm of the library and for no other."""
    assert sum(read_arm(name).verified for name in NAMES) >= 25
    assert set(PUBLISHED) == set(NAMES)


@pytest.mark.parametrize("name", NAMES)
def test_a_verified_arm_agrees_with_two_sources(name):
    """In 200 random postures the flange's origin is where each source has it, and its axes differ from the source's by one fixed rotation.

    Sources differ in how they turn the flange's axes, so any rotation is allowed, but it must be the same in all postures.
    An arm that is unverified agrees with its first source.
    """
    arm, entries = read_arm(name), PUBLISHED[name]
    if arm.verified:
        assert len(entries) >= 2
    else:
        entries = entries[:1]
    robot = Robot.from_mapping(arm.mapping)
    q = np.random.default_rng(1).uniform(-pi, pi, (200, robot.n_joints))
    T = robot.flange(q)
    for entry in entries:
        source = published_flange(entry, q)
        assert np.max(np.abs(T[:, :3, 3] - source[:, :3, 3])) < (arm.agreement or 1e-6)
        between = np.swapaxes(source[:, :3, :3], 1, 2) @ T[:, :3, :3]
        assert np.max(np.abs(between - between[0])) < 1e-6


@pytest.mark.parametrize("name", NAMES)
def test_an_arm_is_described_completely(name):
    """Maker, model, sources and their status stand in the file; an unverified arm says why."""
    arm = read_arm(name)
    assert arm.mapping["name"] == name and arm.maker and arm.model and arm.limits_source
    assert len(arm.sources) == len(set(arm.sources)) >= (2 if arm.verified else 1)
    assert len(PUBLISHED[name]) == len(arm.sources)
    assert (arm.agreement is not None and arm.agreement <= 1e-5) if arm.verified else arm.note


@pytest.mark.parametrize("name", NAMES)
def test_limits_are_plausible(name):
    """Every joint has limits, at least 60 degrees apart and within two turns of zero."""
    limits = np.array([joint["limits"] for joint in read_arm(name).mapping["joints"]])
    assert np.all(np.diff(limits) > np.deg2rad(60)) and np.max(np.abs(limits)) < 4.001 * pi


@pytest.mark.parametrize("name", NAMES)
def test_the_reach_is_the_makers(name):
    """The largest distance of the wrist centre or the flange from axis 1 is the stated reach, to the tolerance in the file."""
    arm = read_arm(name)
    robot = Robot.from_mapping(arm.mapping)
    low, high = robot.limits.T

    def distance(q):
        q = np.atleast_2d(q)
        frames = robot.frames(q)
        T = frames[:, -1] @ robot.T_n_flange if arm.reach_at == "flange" else frames[:, -2]
        return np.hypot(T[:, 0, 3], T[:, 1, 3])

    q = np.random.default_rng(2).uniform(low, high, (4000, robot.n_joints))
    best = q[np.argsort(distance(q))[-3:]]
    bounds = list(zip(low, high, strict=True))
    found = max(-minimize(lambda x: -distance(x)[0], x, method="L-BFGS-B", bounds=bounds).fun for x in best)
    assert found == pytest.approx(arm.reach, abs=arm.reach_tolerance)
    assert arm.reach_tolerance < 0.16 * arm.reach


@pytest.mark.parametrize(
    ("config", "name"), [("ur10e", "ur10e"), ("panda", "franka_panda"), ("vs060", "denso_vs060")]
)
def test_the_arms_of_the_scenes_are_those_of_the_library(config, name):
    """The robot of a scene and the library's arm of that model have the same flange."""
    ours, library = (Robot.from_mapping(m) for m in (robot_mapping(config), read_arm(name).mapping))
    q = np.random.default_rng(3).uniform(-pi, pi, (50, ours.n_joints))
    assert np.max(np.abs(ours.flange(q)[:, :3, 3] - library.flange(q)[:, :3, 3])) < 1e-9


@pytest.mark.parametrize(
    ("written", "name"),
    [
        ("KUKA KR 6 R900-2", "kuka_kr6_r900_2"),
        ("UR-5e", "ur5e"),
        ("m-10ia/12", "fanuc_m10ia"),
        ("M1013", "doosan_m1013"),
    ],
)
def test_a_name_is_found_however_it_is_written(written, name):
    """Case, blanks and punctuation do not matter, and the maker's model is a name too."""
    assert read_arm(written).name == name


def test_a_wrong_name_suggests_similar_ones():
    """A shortened model suggests the arms whose names contain it; a name unlike any arm's suggests none."""
    with pytest.raises(InvalidInput, match=r"did you mean .*kuka_kr6_r900_2") as error:
        read_arm("kr6 r900")
    assert "kuka_kr6_r900_sixx" in str(error.value)
    with pytest.raises(InvalidInput) as error:
        read_arm("toaster")
    assert "did you mean" not in str(error.value) and "--urdf" in str(error.value)


@pytest.mark.parametrize(
    ("name", "file", "base", "tip"),
    [
        ("franka_panda", "franka_panda/panda.urdf", "panda_link0", "panda_link8"),
        ("ufactory_xarm6", "xarm/xarm6_robot.urdf", "link_base", "link6"),
    ],
)
def test_an_arm_agrees_with_the_urdf_that_pybullet_ships(name, file, base, tip):
    """The flange is where that description has it, joint directions included, to the rounding of right angles in the description."""
    data = pytest.importorskip("pybullet_data")
    shipped, _ = robot_from_urdf(Path(data.getDataPath()) / file, base, tip)
    ours = Robot.from_mapping(read_arm(name).mapping)
    q = np.random.default_rng(4).uniform(-pi, pi, (100, ours.n_joints))
    assert np.max(np.abs(ours.flange(q)[:, :3, 3] - shipped.flange(q)[:, :3, 3])) < 1e-5
