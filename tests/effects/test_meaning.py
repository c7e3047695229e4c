"""What the coefficients mean: workcells flawed by this test's own physics are explained to the last digit.

Data without noise from ``injected``: freeing the right effect leaves no residual, gives the injected
coefficients back where they have a name in the plant, and predicts the true frames of poses never seen.
"""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from scalar.effects.acquisition import range_middle
from scalar.effects.command_line import parse_effects
from scalar.estimation.calibrate import calibrate
from tests import kinematics
from tests.effects.injected import BETA, Flaws, PoseData, make_cell, on_joint, sag
from tests.kinematics import joint_names

STATED = 1e-7  # m: so small that no prior of an effect's size matters
RESIDUAL = 2e-8  # m
PREDICTION = 2e-6  # m, over 300 poses


def approaches(rng, n_poses, n_joints):
    return {f"approach{j + 1}": rng.choice([-1.0, 1.0], n_poses) for j in range(n_joints)}


def warming(rng, n_poses, n_joints):
    time = np.cumsum(rng.uniform(5.0, 15.0, n_poses))
    return {"time": time, "temperature": 21.0 + 6.0 * (1 - np.exp(-time / 600.0))}


def explained(flaws, effects, **settings):
    """Return the calibration of a noise-free flawed workcell with effects freed, and the workcell."""
    cell = make_cell(
        flaws, noise=0.0, stated_noise=STATED, poses_per_plane=40, points_per_scan=12, **settings
    )
    return calibrate(cell.dataset, effects=parse_effects(effects, cell.dataset)), cell


def somewhere(cell, count):
    """Return random poses within the limits, at the end."""
    limits = cell.scene.truth.limits
    q = limits[:, 0] + np.random.default_rng(1).random((count, len(limits))) * np.ptp(limits, axis=1)
    return PoseData(q, np.full(count, float(cell.dataset.n_poses - 1)), {})


def apart(result, q, T, **columns):
    """Return the largest distance [m] of predicted and true positions, the base moved as fits best."""
    table = pd.DataFrame(q, columns=joint_names(q.shape[1])).assign(pose=np.arange(len(q)), **columns)
    p, truth = result.predict(table)[:, :3, 3], T[:, :3, 3]
    a, b = p - p.mean(0), truth - truth.mean(0)
    U, _, Vt = np.linalg.svd(a.T @ b)
    R = U @ np.diag([1.0, 1.0, np.sign(np.linalg.det(U @ Vt))]) @ Vt
    return float(np.linalg.norm(a @ R - b, axis=1).max())


def assert_explained(result, cell):
    """Assert that nothing is left, and that poses never seen are predicted without stating their order."""
    assert result.residual_rms < RESIDUAL
    at = somewhere(cell, 300)
    assert apart(result, at.q, cell.sensor(at)) < PREDICTION


def tilting(truth, stiff=(1.0, 1.0)):
    """Return the motions of a base that tilts by 3e-6 rad for each N m under the weight of the links, times ``stiff`` about x and y."""
    masses = np.array([0.0, 9.0, 5.0, 3.0, 1.0, 0.5])

    def tilt(at):
        moment = np.zeros((len(at.q), 3))
        T = np.broadcast_to(truth.T_base_0, (len(at.q), 4, 4))
        for i in range(6):
            a, alpha, d, theta, _ = truth.geometry[:, i]
            T = T @ kinematics.rotation(0, alpha) @ kinematics.translation(0, a)
            T = T @ kinematics.rotation(2, at.q[:, i] + theta) @ kinematics.translation(2, d)
            moment += masses[i] * np.cross(T[:, :3, 3], [0.0, 0.0, -9.81])
        w = 3e-6 * moment * [*stiff, 0.0]
        turn = np.tile(np.eye(4), (len(w), 1, 1))
        for k, vector in enumerate(w):
            turn[k, :3, :3] = kinematics.rotate_about(vector, np.linalg.norm(vector))
        return turn

    return tilt


def value(result, name):
    return result.parameters()[name]["value"]


JOINT_ERRORS = {
    "joint_harmonic:4:2": (4, lambda q: 3e-4 * np.sin(2 * q[:, 3]) - 1e-4 * np.cos(2 * q[:, 3])),
    "joint_harmonic:3:17": (3, lambda q: 2e-4 * np.sin(17 * q[:, 2])),
    "joint_ripple:2:40": (2, lambda q: 2e-4 * np.cos(40 * q[:, 1])),
    "joint_scale:2": (2, lambda q: 1e-3 * q[:, 1]),
    "joint_coupling:6:5": (6, lambda q: -1e-3 * q[:, 4]),
}


@pytest.mark.parametrize("effects", JOINT_ERRORS)
def test_joint_errors_are_explained_with_their_signs(effects):
    """Gear errors, scale and coupling are found with their signs, where the arm stands at q + dq and the encoders read q."""
    joint, error = JOINT_ERRORS[effects]
    result, cell = explained(Flaws(joints=on_joint(joint, lambda at: error(at.q))), effects, seed=21)
    assert_explained(result, cell)
    known = {
        "joint_harmonic_4_2.sin_rad": 3e-4,
        "joint_harmonic_4_2.cos_rad": -1e-4,
        "joint_harmonic_3_17.sin_rad": 2e-4,
        "joint_ripple_2_40.cos_rad": 2e-4,
        "joint_scale_2.scale_rad_per_rad": 1e-3,
        "joint_coupling_6_5.coupling_rad_per_rad": -1e-3,
    }
    mine = {n: v for n, v in known.items() if n.startswith(effects.replace(":", "_"))}
    assert mine
    for name, truth in mine.items():
        assert value(result, name) == pytest.approx(truth, abs=1e-8), name


def test_backlash_is_explained_by_the_approach():
    """A joint arrives short by half its play on the side from which it comes, and predicting needs that side."""
    error = on_joint(3, lambda at: 2e-4 * at.columns["approach3"])
    result, cell = explained(Flaws(joints=error), "joint_backlash:3", seed=22, columns=approaches)
    assert result.residual_rms < RESIDUAL
    assert value(result, "joint_backlash_3.half_width_rad") == pytest.approx(2e-4, abs=1e-9)
    at = somewhere(cell, 50)
    side = {"approach3": np.ones(50)}
    T = cell.sensor(PoseData(at.q, at.order, side))
    assert apart(result, at.q, T, **side) < PREDICTION


def test_compliance_is_explained_for_any_masses():
    """The compliance of joints under links of unknown mass is explained, because the moments that are tried span those of every arm."""
    rng = np.random.default_rng(23)
    cell = make_cell(seed=23, poses_per_plane=4)
    flaws = Flaws(joints=sag(cell.scene.truth, np.full(6, 1e-5), rng))
    result, cell = explained(flaws, "joint_compliance", seed=23)
    # The column is taken at the nominal arm, some millimetres and a degree off: a hundredth of the sag.
    assert result.residual_rms < 2e-5
    result, cell = explained(flaws, "joint_compliance", seed=23, length_error=0.0, angle_error=0.0)
    assert_explained(result, cell)


def test_a_nonparallel_axis_is_explained():
    """Hayati's angle of a joint whose axis is nearly parallel to the one before is found."""
    geometry = np.zeros((5, 6))
    geometry[BETA, 2] = 1.5e-3
    flaws = Flaws(geometry=lambda at: np.broadcast_to(geometry, (len(at.q), 5, 6)))
    result, cell = explained(flaws, "axis_nonparallel:3", seed=24)
    assert_explained(result, cell)
    assert value(result, "axis_nonparallel_3.beta_rad") == pytest.approx(1.5e-3, abs=1e-8)


@pytest.mark.parametrize("stiff", [(1.0, 1.0), (1.0, 0.3)])
def test_a_tilting_base_is_explained(stiff):
    """The tilt of a pedestal under the moving weight is explained, with the same compliance about both axes or with a smaller one about y."""
    settings = {"length_error": 0.0, "angle_error": 0.0}
    cell = make_cell(seed=25, poses_per_plane=4, **settings)
    tilt = tilting(cell.scene.truth, stiff)
    result, cell = explained(Flaws(base=tilt), "base_compliance", seed=25, **settings)
    assert_explained(result, cell)


@pytest.mark.parametrize("by", ["temperature", "order"])
def test_growing_lengths_are_explained(by):
    """Lengths that grow with the temperature, or with time where only the order is known, are explained; the
    prediction is for the temperature given, or for the end.
    """
    rate = 5e-4 / 6.0 if by == "temperature" else 5e-4 / 119.0
    cell = make_cell(seed=26, poses_per_plane=4)
    lengths = cell.scene.truth.geometry * np.array([1.0, 0, 1.0, 0, 0])[:, None]

    def growth(at):
        x = at.columns["temperature"] - 21.0 if by == "temperature" else at.order
        return rate * x[:, None, None] * lengths

    columns = warming if by == "temperature" else None
    settings = {"length_error": 0.0, "angle_error": 0.0, "columns": columns}
    result, cell = explained(Flaws(geometry=growth), f"thermal_drift:{by}", seed=26, **settings)
    assert result.residual_rms < RESIDUAL
    at = somewhere(cell, 100)
    warm = {"temperature": np.full(100, 26.5)} if by == "temperature" else {}
    T = cell.sensor(PoseData(at.q, at.order, warm))
    assert apart(result, at.q, T, **warm) < PREDICTION


def test_a_slipped_sensor_is_explained():
    """A sensor that shifts and turns at some pose is explained, and a prediction without ``order`` is for the end."""
    motion = np.eye(4)
    motion[:3, 3] = [4e-4, -2e-4, 3e-4]
    motion[:3, :3] = kinematics.rotate_about(np.array([1.0, 2.0, -1.0]), 2e-3)
    result, cell = explained(Flaws(slip=(61.0, motion)), "sensor_slip:61", seed=27)
    assert_explained(result, cell)
    for axis, truth in zip("xyz", motion[:3, 3], strict=True):
        assert value(result, f"sensor_slip_61.{axis}_m") == pytest.approx(truth, abs=1e-7)
    at = somewhere(cell, 50)
    before = cell.sensor(PoseData(at.q, np.zeros(50), {}))
    assert apart(result, at.q, before, order=np.zeros(50)) < PREDICTION


@pytest.mark.parametrize("axis", ["ray", "z"])
def test_range_errors_are_explained(axis):
    """A zero and a curvature of the range are explained, along the ray or along z."""
    if axis == "ray":
        # r = m + 2e-4, so that m = r - 2e-4.
        result, cell = explained(Flaws(measured=lambda r: r - 2e-4), "range_offset", seed=28)
        assert_explained(result, cell)
        assert value(result, "range_offset.offset_m") == pytest.approx(2e-4, abs=1e-8)

    def curved(m):
        return m + 0.02 * m**2

    def measured(r):
        m = r.copy()
        for _ in range(60):
            m = m - (curved(m) - r) / (1 + 0.04 * m)
        return m

    cell = make_cell(
        noise=0.0, stated_noise=STATED, poses_per_plane=40, points_per_scan=12, seed=28, error_axis=axis
    )
    points = cell.dataset.points
    if axis == "ray":
        r = np.linalg.norm(points, axis=1, keepdims=True)
        points = points * measured(r) / r
    else:
        points = np.column_stack([points[:, 0], measured(points[:, 1])])
    dataset = replace(cell.dataset, points=points)
    result = calibrate(dataset, effects=parse_effects("range_distortion", dataset))
    assert result.residual_rms < RESIDUAL
    # A gain along the ray cannot be seen, and is taken to be right at the middle: the whole workcell shrinks by what it is there.
    expected = 0.02 / (1.0 + 0.04 * range_middle(dataset)) if axis == "ray" else 0.02
    assert value(result, "range_distortion.curvature_per_m") == pytest.approx(expected, abs=1e-5)


@pytest.mark.parametrize("target_plane", ["floor", "wall_x", "wall_y"])
def test_bent_and_moved_target_planes_are_explained(target_plane):
    """A paraboloid, and a knocked target plane, are explained on each target plane; they do not act on the arm's
    predictions.
    """
    result, cell = explained(
        Flaws(bent={target_plane: (2e-3, -1e-3, 3e-3)}), f"plane_bow:{target_plane}", seed=29
    )
    # The rays are cut with the bent target plane; the model takes its height where the measured point is: alike to
    # second order in the slope.
    assert_explained(result, cell)
    knocked = Flaws(moved={target_plane: (70.0, 5e-4, (2e-5, -1e-5))})
    result, cell = explained(knocked, f"plane_moved:{target_plane}:70", seed=29)
    assert_explained(result, cell)


def test_two_sessions_share_a_bent_target_plane():
    """A target plane that is bent is bent in both sessions alike, although its place is refitted in each."""
    flaws = Flaws(bent={"floor": (2e-3, -1e-3, 3e-3)})
    cell = make_cell(flaws, seed=30, noise=0.0, stated_noise=STATED, poses_per_plane=60, points_per_scan=12)
    sessions = np.repeat([1, 2], cell.dataset.n_poses // 2)
    dataset = replace(cell.dataset, poses=cell.dataset.poses.assign(session=sessions))
    result = calibrate(dataset, effects=parse_effects("plane_bow:floor", dataset))
    assert result.residual_rms < RESIDUAL
