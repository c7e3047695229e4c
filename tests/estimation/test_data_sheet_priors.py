"""What poses do not show stays near the data sheet, with a standard error that says so; what they show is untouched."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from scipy.linalg import null_space
from scipy.stats import chi2

from scalar import calibrate
from scalar.errors import Undetermined
from scalar.estimation.data_sheet_priors import data_sheet_priors
from scalar.estimation.geometry_fit import geometry_fit
from scalar.estimation.residuals import Residuals
from scalar.geometry.robot import Tolerance
from scalar.sensors import measure
from tests.kinematics import joint_names
from tests.random_scene import make_scene

TOOL = np.eye(4)
TOOL[:3, 3] = (0.05, -0.03, 0.1)
NOISE = 5e-5  # m
SIZE = 3e-4  # m and rad, of the errors of data sheets
GEAR = 1e-4  # rad
EVERYWHERE = 0.6  # of the joint limits


def workcell(seed, q, size=SIZE, gear=0.0, exact=None):
    """Return a tracked VS060 at joint angles ``q`` with its truth; the encoders read what a worn gear makes of each angle.

    Args:
        seed: Of errors, noise and gears. q: ``(N, 6)`` [rad], as read. size: Of the data sheet's errors [m and rad].
        gear: Amplitude [rad] of each joint's own error, of some order from 3 to 20. exact: As in ``make_scene``.
    """
    made = make_scene(
        kind="tracker",
        seed=seed,
        poses_per_plane=4,
        noise=NOISE,
        length_error=size,
        angle_error=size,
        exact=exact,
        T_flange_sensor=TOOL,
    )
    rng = np.random.default_rng([seed, 1])
    order, phase = rng.integers(3, 21, 6), rng.uniform(0, 2 * np.pi, 6)

    def stood(read):
        return read + gear * np.sin(order * read + phase)

    T = made.truth.T_tracker_base
    points = made.truth.sensor(stood(q))[:, :3, 3] @ T[:3, :3].T + T[:3, 3]
    poses = pd.DataFrame(q, columns=joint_names(6))
    poses.insert(0, "pose", np.arange(len(q)))
    dataset = replace(
        made.dataset,
        poses=poses,
        points=points + NOISE * rng.standard_normal(points.shape),
        starts=np.arange(len(q) + 1),
    )
    return dataset, lambda q: made.truth.sensor(stood(q))[:, :3, 3] @ T[:3, :3].T + T[:3, 3]


def stating(dataset, length=SIZE, angle=SIZE):
    """Return the dataset with the maker's tolerance in it."""
    return replace(dataset, robot=replace(dataset.robot, tolerance=Tolerance(length, angle)))


def elsewhere(rng, count=60):
    """Return joint angles ``(count, 6)`` [rad] in the middle of the limits."""
    return rng.uniform(-EVERYWHERE, EVERYWHERE, (count, 6)) * np.array([2.9, 2.0, 2.0, 2.9, 2.0, 3.1])


def grid(count=8, small=0.017):
    """Return a grid in q2 and q3 with small moves of every other joint at each of its points."""
    corners = [(a, b) for a in np.linspace(-0.8, 0.6, count) for b in np.linspace(0.3, 1.8, count)]
    rows = []
    for a, b in corners:
        centre = np.array([0.3, a, b, 0.3, 0.5, 0.2])
        rows += [centre, *(centre + small * np.eye(6)[j] for j in (0, 3, 4, 5))]
    return np.array(rows)


def as_tracked(calibration, q):
    """Return predicted positions ``(N, 3)`` in the tracker's frame."""
    T = calibration.model.target.transforms[0]
    return calibration.predict(q)[:, :3, 3] @ T[:3, :3].T + T[:3, 3]


def base_and_tool(dataset):
    """Return the calibration of the same data in which the data sheet is believed."""
    names = [name for name in dataset.robot.parameter_names if not name.startswith("beta")]
    return calibrate(dataset, fix=names)


def rms(errors):
    """Return the root mean square length of rows ``(N, 3)``."""
    return float(np.sqrt(np.mean(np.sum(errors**2, axis=1))))


def test_the_estimate_is_the_posterior_mean_of_a_dense_computation():
    """For few poses and a data sheet that is almost right, mean and covariance are those of the gain form ``S J' (J S J' + 1)^-1``."""
    tiny = 5e-5  # m and rad: the square of it is nothing
    rng = np.random.default_rng(0)
    dataset, _ = workcell(3, elsewhere(rng, 12), size=tiny)
    calibration = calibrate(stating(dataset, tiny, tiny))
    assert calibration.model.misfit_ratio == 1.0
    at = replace(calibration.model, priors=())
    r, J = Residuals.of(dataset, at, measure(dataset)).linearise_measured(at)
    priors = {prior.name: prior for prior in calibration.model.priors}
    known = [name for name in calibration.free if name in priors]
    flat = null_space(J[:, [at.names.index(n) for n in calibration.free if n not in priors]].T).T
    r, J = flat @ r, flat @ J[:, [at.names.index(name) for name in known]]
    S = np.diag([priors[name].std ** 2 for name in known])
    off = np.array([priors[name].mean - at.vector[at.names.index(name)] for name in known])
    gain = S @ J.T @ np.linalg.inv(J @ S @ J.T + np.eye(len(r)))
    covariance = S - gain @ J @ S
    std = np.sqrt(np.diag(covariance))
    # The posterior mean is where the fit ended: seen from there, it is nowhere else.
    np.testing.assert_array_less(np.abs(off - gain @ (r + J @ off)) / std, 2e-3)
    np.testing.assert_allclose([calibration.std[name] for name in known], std, rtol=5e-3)
    shares = std / [priors[name].std for name in known]
    assert shares.min() < 0.3 and shares.max() > 0.9


@pytest.mark.parametrize("stated", [False, True])
def test_priors_leave_alone_what_the_data_determine(stated):
    """With poses all over the workspace, priors change nothing by more than 2 % of a standard error of the fit without them."""
    made = make_scene(kind="tracker", seed=21, poses_per_plane=60, noise=2e-5)
    dataset = stating(made.dataset, 2e-3, np.deg2rad(1.0)) if stated else made.dataset
    without = calibrate(made.dataset)
    assert not without.model.priors
    with_them = calibrate(dataset)
    for name, std in without.std.items():
        i = without.model.names.index(name)
        assert abs(with_them.model.vector[i] - without.model.vector[i]) < 0.02 * std


@pytest.mark.slow
@pytest.mark.parametrize("stated", [True, False])
def test_a_grid_is_calibrated_and_says_how_little_it_knows(stated):
    """Poses that leave directions undetermined leave them to the data sheet: standard errors are small on the grid and large off it.

    The tolerance is the maker's where it is stated, and else estimated from the arm.
    """
    dataset, _ = workcell(5, grid())
    calibration = calibrate(stating(dataset) if stated else dataset)
    near, _ = calibration.predict_std(dataset.q)
    far, _ = calibration.predict_std(elsewhere(np.random.default_rng(1)))
    assert np.median(far) > 1.3 * np.median(near)
    assert calibration.summary["kept_near_data_sheet"]


@pytest.mark.parametrize("stated", [True, False])
@pytest.mark.parametrize("seed", range(3))
def test_a_grid_with_gears_predicts_elsewhere_no_worse_than_base_and_tool(seed, stated):
    """On a grid in q2 and q3 with gear errors, a calibration predicts poses all over no worse than a fit of base and tool alone."""
    dataset, truth = workcell(40 + seed, grid(), gear=GEAR)
    q = elsewhere(np.random.default_rng(seed), 200)
    calibrated = rms(as_tracked(calibrate(stating(dataset) if stated else dataset), q) - truth(q))
    believed = rms(as_tracked(base_and_tool(dataset), q) - truth(q))
    assert calibrated < 1.05 * believed


def test_where_effects_follow_the_misfit_tightens_no_priors():
    """If gears err by ten times the noise, a calibration rests on priors, and a diagnosis, which may find the gears, does not."""
    dataset, _ = workcell(60, elsewhere(np.random.default_rng(8), 40), gear=10 * GEAR)
    assert geometry_fit(dataset)[0].priors
    model, prepared = geometry_fit(dataset, effects_follow=True)
    assert not model.priors and not prepared.coarse.priors


@pytest.mark.parametrize("seed", range(3))
def test_fifteen_poses_with_gears_predict_no_worse_than_base_and_tool(seed):
    """With few poses of an arm whose gears err, learned priors keep the fit from following the gears, with no tolerance stated."""
    rng = np.random.default_rng([seed, 3])
    dataset, truth = workcell(60 + seed, elsewhere(rng, 15), gear=2 * GEAR)
    q = elsewhere(rng, 200)
    calibration = calibrate(dataset)
    assert calibration.model.priors
    assert rms(as_tracked(calibration, q) - truth(q)) < rms(as_tracked(base_and_tool(dataset), q) - truth(q))


@pytest.mark.slow
def test_fifteen_scans_are_calibrated_with_a_tolerance_and_nine_are_refused():
    """For 30 equations and 32 unknowns the data sheet supplies what is missing, and the error is within its predicted size."""
    size, angle = 2e-3, np.deg2rad(1.0)
    made = make_scene(seed=0, poses_per_plane=5)
    calibration = calibrate(stating(made.dataset, size, angle))
    q = made.truth.poses(300, np.random.default_rng(0)).filter(like="q").to_numpy()
    error = calibration.predict(q)[:, :3, 3] - made.truth.sensor(q)[:, :3, 3]
    position_std, _ = calibration.predict_std(q)
    assert rms(error) < 2.0 * np.sqrt(np.mean(position_std**2))
    assert rms(error) < rms(
        type(calibration).nominal(made.dataset).predict(q)[:, :3, 3] - made.truth.sensor(q)[:, :3, 3]
    )
    few = make_scene(seed=0, poses_per_plane=3)
    with pytest.raises(Undetermined, match="2 times as many equations"):
        calibrate(stating(few.dataset, size, angle))


@pytest.mark.slow
def test_ellipsoids_cover_in_small_workcells():
    """Over a hundred workcells of 14 poses in a corner of the workspace, 95 % ellipsoids hold 90 to 98 % of poses all over it."""
    inside = []
    for seed in range(100):
        rng = np.random.default_rng([seed, 9])
        centre = np.array([0.2, 0.1, 0.9, 0.2, 0.6, 0.1])
        dataset, truth = workcell(seed, centre + rng.uniform(-0.4, 0.4, (14, 6)), exact=())
        calibration = calibrate(stating(dataset))
        q = elsewhere(rng, 20)
        # The base's own parameters are part of the tracker's frame: positions are compared there, by the free parameters and that frame.
        at = calibration.model
        rows = Residuals.of(
            replace(dataset, poses=_poses(q), points=truth(q), starts=np.arange(len(q) + 1)), at
        )
        r, J = rows.linearise_measured(replace(at, priors=()))
        free = [at.names.index(name) for name in calibration.free]
        C = J[:, free] @ calibration.covariance @ J[:, free].T
        sigma = rows.measurement.sigma
        for k in range(len(q)):
            block = slice(3 * k, 3 * k + 3)
            e = r[block] * sigma
            inside.append(e @ np.linalg.solve(C[block, block] * sigma**2, e) < chi2.ppf(0.95, 3))
    assert 0.90 < np.mean(inside) < 0.98


def _poses(q):
    poses = pd.DataFrame(q, columns=joint_names(6))
    poses.insert(0, "pose", np.arange(len(q)))
    return poses


def test_a_saved_calibration_keeps_its_priors(tmp_path):
    """The parameters in the file state their priors from the data sheet, and read back with the same ones."""
    dataset, _ = workcell(6, grid())
    calibration = calibrate(stating(dataset))
    calibration.save(tmp_path / "calibration.json")
    again = type(calibration).load(tmp_path / "calibration.json")
    stated = {name: entry["prior"] for name, entry in again.parameters().items() if entry["prior"]}
    assert stated == {p.name: {"value": p.mean, "std": p.std} for p in calibration.model.priors}
    assert stated["a_3"] == {"value": float(dataset.robot.geometry[0, 2]), "std": SIZE}
    assert again.model.nominal.tolerance == Tolerance(SIZE, SIZE)


def test_a_model_with_other_priors_keeps_its_coordinates_and_takes_the_new_rows():
    """After the rows of some priors were asked for, other priors and another weight give the rows of a model that never had the first ones."""
    model, prepared = geometry_fit(make_scene(seed=1, poses_per_plane=15).dataset)
    priors = data_sheet_priors(model, prepared.free)
    first = model.with_priors(priors[:2], 1.0)
    assert len(first.prior_rows()[0]) == 2
    found, expected = first.with_priors(priors[1:], 2.0), replace(model, priors=priors[1:], misfit_ratio=2.0)
    assert found.names == expected.names
    np.testing.assert_array_equal(found.T_flange_sensor, expected.T_flange_sensor)
    for ours, theirs in zip(found.prior_rows(), expected.prior_rows(), strict=True):
        np.testing.assert_array_equal(ours, theirs)
