"""Over many draws of the noise on one scene: the spread is the bound, the claimed errors are true, nothing is
biased.

One workcell, 3N = 120, M = 100, 0.1 mm along the rays; 400 draws. The Cramer-Rao bound is computed here from all
points one by
one and by central differences of the tests' own kinematics, so that it shares nothing with the covariance it
judges. What is allowed
follows from the sampling distribution of 400 draws, with one false alarm in ten thousand runs of a test.
"""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from scipy.stats import chi2

from scalar.estimation.conclude import conclude
from scalar.estimation.joint_fit import fit_all
from scalar.estimation.prepare import prepare
from scalar.estimation.residuals import Residuals
from scalar.estimation.result import Calibration
from tests import kinematics
from tests.kinematics import PARAMETER_KINDS, joint_names
from tests.random_scene import make_scene
from tests.workcell import Scene

DRAWS = 400
NOISE = 1e-4  # m
FALSE_ALARM = 1e-4
SEED = 2018  # the paper's year; any other does
ISSUE = 0.10  # issue 2: the spread is within 10 % of the bound


@dataclass(frozen=True, eq=False)
class Draws:
    """Calibrations of the same scene: errors ``(n, F)``, claimed ``std`` ``(n, F)``, and errors of
    predictions.
    """

    scene: Scene
    names: tuple[str, ...]
    bound: np.ndarray
    errors: np.ndarray
    std: np.ndarray
    misfit_p_values: np.ndarray
    position_errors: np.ndarray
    orientation_errors: np.ndarray
    claimed: tuple[np.ndarray, np.ndarray]


def true_values(scene: Scene, calibration: Calibration) -> dict[str, float]:
    """Return the true value of every free parameter, normals counted from the initial guesses."""
    values = scene.truth.parameters()
    target = calibration.model.target
    for k, name in enumerate(target.names):
        n = scene.truth.normals[k]
        u, v = target.tangents[k] @ n / (n @ target.reference_normals[k])
        values.update(
            {f"normal_{name}_u": u, f"normal_{name}_v": v, f"distance_{name}": scene.truth.distances[k]}
        )
    return values


def estimates_near(calibration: Calibration, values: dict[str, float]) -> np.ndarray:
    """Return the free parameters; of the two rotation vectors of the scanner (half a turn) the one near
    the truth.
    """
    found = dict(zip(calibration.model.names, calibration.model.vector, strict=True))
    turn = np.array([found[f"sensor_r{axis}"] for axis in "xyz"])
    true = np.array([values[f"sensor_r{axis}"] for axis in "xyz"])
    other = turn * (1 - 2 * np.pi / np.linalg.norm(turn))
    if np.linalg.norm(other - true) < np.linalg.norm(turn - true):
        found.update({f"sensor_r{axis}": x for axis, x in zip("xyz", other, strict=True)})
    return np.array([found[name] for name in calibration.free])


def cramer_rao(scene: Scene, calibration: Calibration, values: dict[str, float]) -> np.ndarray:
    """Return the covariance ``(F, F)`` of the best unbiased estimator, from all points, by central
    differences.
    """
    data, truth, target = scene.dataset, scene.truth, calibration.model.target
    owner = np.repeat(np.arange(data.n_poses), np.diff(data.starts))
    k, (x, z) = data.plane_index[owner], scene.clean.T

    def residual(change: dict[str, float]) -> tuple[np.ndarray, np.ndarray]:
        at = {**values, **{name: values[name] + step for name, step in change.items()}}
        geometry = np.array([[at[f"{kind}_{i + 1}"] for i in range(6)] for kind in PARAMETER_KINDS])
        turn = np.array([at[f"sensor_r{axis}"] for axis in "xyz"])
        T_fs = np.eye(4)
        T_fs[:3, 3] = [at[f"sensor_{axis}"] for axis in "xyz"]
        T_fs[:3, :3] = kinematics.rotate_about(turn, float(np.linalg.norm(turn)))
        tangent = np.array([[at[f"normal_{n}_{c}"] for c in "uv"] for n in target.names])
        normals = target.reference_normals + np.einsum("kt,ktx->kx", tangent, target.tangents)
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        distances = np.array([at[f"distance_{n}"] for n in target.names])
        T = (kinematics.chain(geometry, data.q, truth.T_base_0) @ truth.T_n_flange @ T_fs)[owner]
        along = T[:, :3, 0] * x[:, None] + T[:, :3, 2] * z[:, None]
        n = normals[k]
        f = np.sum(n * (along + T[:, :3, 3]), axis=1) - distances[k]
        return f, np.abs(np.sum(n * along, axis=1)) / np.hypot(x, z)

    f, incidence = residual({})
    assert np.abs(f).max() < 1e-12
    h = 1e-6
    J = np.stack([(residual({n: h})[0] - residual({n: -h})[0]) / (2 * h) for n in calibration.free], axis=1)
    J /= (NOISE * incidence)[:, None]
    return np.linalg.inv(J.T @ J)


@pytest.fixture(scope="module")
def draws() -> Draws:
    """Fit the scene 400 times; start and choice of what to hold are those of the first draw."""
    scene = make_scene(seed=SEED, noise=NOISE)
    rng = np.random.default_rng(SEED)
    first = prepare(scene.dataset)
    poses = scene.truth.poses(20, rng)
    T_true = scene.truth.sensor(poses[joint_names(6)].to_numpy())
    errors, std, p_values, position, orientation = [], [], [], [], []
    for _ in range(DRAWS):
        data = scene.redraw(rng)
        residuals = Residuals.of(data, first.initial.model).reweighted(first.initial.model)
        prepared = replace(first, residuals=residuals)
        calibration = conclude(data, prepared, *fit_all(data, prepared))
        if not errors:
            values = true_values(scene, calibration)
            truth = np.array([values[name] for name in calibration.free])
            bound = cramer_rao(scene, calibration, values)
            claimed = calibration.predict_std(poses)
        errors.append(estimates_near(calibration, values) - truth)
        std.append([calibration.std[name] for name in calibration.free])
        p_values.append(calibration.summary["misfit_p_value"])
        T = calibration.predict(poses)
        position.append(T[:, :3, 3] - T_true[:, :3, 3])
        orientation.append(kinematics.rotation_vector(T[:, :3, :3] @ np.swapaxes(T_true[:, :3, :3], 1, 2)))
    return Draws(
        scene, calibration.free, bound, np.array(errors), np.array(std), np.array(p_values),
        np.array(position), np.array(orientation), claimed,
    )  # fmt: skip


def allowed(count: int) -> tuple[float, float]:
    """Return between what the ratio of a sample's root mean square and the true one lies, ``count``
    ratios being looked at.
    """
    tail = FALSE_ALARM / count / 2
    return np.sqrt(chi2.ppf(tail, DRAWS) / DRAWS), np.sqrt(chi2.ppf(1 - tail, DRAWS) / DRAWS)


def test_the_claimed_covariance_is_the_bound(draws):
    """The standard errors of a single calibration are the Cramer-Rao bound to a percent: Jacobian and
    weights are right.
    """
    ratio = draws.std[0] / np.sqrt(np.diag(draws.bound))
    np.testing.assert_allclose(ratio, 1.0, atol=0.01)


def test_the_spread_of_every_parameter_is_within_a_tenth_of_the_bound(draws):
    """For each free parameter, the RMS error is within a tenth of the bound's standard error, widened by the sampling of 400 draws."""
    ratio = np.sqrt(np.mean(draws.errors**2, axis=0) / np.diag(draws.bound))
    low, high = allowed(len(draws.names))
    assert np.all(ratio > (1 - ISSUE) * low), dict(zip(draws.names, ratio.tolist(), strict=True))
    assert np.all(ratio < (1 + ISSUE) * high), dict(zip(draws.names, ratio.tolist(), strict=True))


def test_the_spread_as_a_whole_is_the_bound(draws):
    """The sum of ``e' C^-1 e`` over all draws is a chi-square with 32 x 400 degrees of freedom, which leaves room for 3.5 %."""
    whitened = np.linalg.solve(np.linalg.cholesky(draws.bound), draws.errors.T)
    freedom = whitened.size
    total = np.sum(whitened**2)
    assert (
        chi2.ppf(FALSE_ALARM / 2, freedom) * 0.99**2
        < total
        < chi2.ppf(1 - FALSE_ALARM / 2, freedom) * 1.01**2
    )


def test_no_direction_spreads_otherwise(draws):
    """No combination of parameters is worse or better than the bound, within Davidson and Szarek's
    limits of a sample.
    """
    whitened = np.linalg.solve(np.linalg.cholesky(draws.bound), draws.errors.T)
    s = np.linalg.svd(whitened, compute_uv=False) / np.sqrt(DRAWS)
    slack = np.sqrt(len(draws.names) / DRAWS) + np.sqrt(2 * np.log(2 / FALSE_ALARM) / DRAWS)
    assert 1 - slack < s[-1] <= s[0] < 1 + slack


def test_errors_in_standard_errors_have_unit_spread_and_no_bias(draws):
    """(hat - true) / std, with each draw's own std, has a root mean square of one and a mean of zero."""
    z = draws.errors / draws.std
    low, high = allowed(len(draws.names))
    rms = np.sqrt(np.mean(z**2, axis=0))
    assert np.all((rms > 0.98 * low) & (rms < 1.02 * high))
    limit = np.sqrt(chi2.ppf(1 - FALSE_ALARM / len(draws.names), 1) / DRAWS)
    assert np.all(np.abs(z.mean(axis=0)) < limit + 0.05)


def test_the_predicted_poses_spread_as_predict_std_says(draws):
    """The root mean square errors of position and orientation at 20 poses agree with those that one calibration states."""
    low, high = allowed(40)
    for errors, claimed in zip((draws.position_errors, draws.orientation_errors), draws.claimed, strict=True):
        ratio = np.sqrt(np.mean(np.sum(errors**2, axis=2), axis=0)) / claimed
        assert np.all((ratio > 0.98 * low) & (ratio < 1.02 * high)), ratio


def test_the_p_value_of_the_misfit_is_uniform(draws):
    """With the stated noise alone, a tenth of the p-values lies below 0.1 and a tenth above 0.9."""
    share = FALSE_ALARM / 4
    for low, high in ((0.0, 0.1), (0.9, 1.0)):
        count = np.count_nonzero((draws.misfit_p_values >= low) & (draws.misfit_p_values <= high))
        spread = np.sqrt(DRAWS * 0.1 * 0.9)
        assert abs(count - DRAWS * 0.1) < spread * np.sqrt(chi2.ppf(1 - share, 1)) + 1
