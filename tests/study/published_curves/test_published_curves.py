"""The explanation of the published curves: effects add up as real fits do, the likelihood is the normal law, and what is injected is found."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.stats import multivariate_normal
from study.common.in_memory import dataset_in_memory
from study.common.statistics import QUANTITIES
from study.published_curves.candidates import Candidate, Prediction, predict
from study.published_curves.curves import Setting, read_curves
from study.published_curves.ensemble import Sizes, build_ensemble, initial_planes
from study.published_curves.recovery import recover
from study.published_curves.stops import follow, stops_at
from study.published_curves.support import KAPPA, held_out, log_likelihood, offsets_found, refine, weigh
from study.published_curves.workcell import shifts, simulate_workcell

from scalar.baseline.fit import calibrate_baseline
from scalar.data.poses import Poses
from scalar.evaluate import pose_errors, true_frames
from scalar.simulation.config import load_config
from scalar.simulation.scene import simulate

SCENES = Path(__file__).parents[3] / "configs/scenes"
BASE = Setting(poses=48, points=30, sigma=1e-4, offset=0.01, tilt=1.0)
STEP = 1e-3


def scene_config(**noise):
    """Return a small workcell whose walls lean, so that the baseline has no root at zero."""
    config = load_config(SCENES / "paper_tilted.yaml")
    sensor = {**config["sensor"], "points_per_scan": BASE.points}
    return {**config, "seed": 3, "poses_per_plane": BASE.poses // 3, "sensor": sensor, "noise": noise}


@pytest.fixture(scope="module")
def workcell():
    """Return the small workcell, linearised."""
    return simulate_workcell(scene_config(), SCENES, 300)


@pytest.fixture(scope="module")
def ensemble():
    """Return a few workcells with rounding and the solver's paths."""
    settings = [BASE, Setting(**{**BASE.__dict__, "sigma": 5e-5})]
    return build_ensemble(scene_config(), SCENES, [1, 2, 3], 4, settings, [STEP], 2)


@pytest.mark.parametrize(
    "noise",
    [
        {"range_noise_std_m": 1e-4},
        {"scan_bias_std_m": 1e-4},
        {"joint_noise_std_rad": 1e-4},
        {"range_noise_std_m": 1e-4, "range_quantum_m": STEP},
    ],
    ids=["point", "scan", "joint", "rounded"],
)
def test_the_linear_shift_is_what_the_published_fit_finds(workcell, noise):
    """The simulator's own errors, carried by the derivatives, give the pose errors of a fit through lmfit."""
    config = scene_config(**noise)
    scene = simulate({**config, "truth_poses": 300}, base_dir=SCENES)
    held = config["initial_model"]["exact"]
    fitted = calibrate_baseline(dataset_in_memory(scene), reading="clip", points="compressed", fixed=held)
    found = pose_errors(true_frames(scene.truth_poses), fitted.predict(scene.truth_poses))

    errors = workcell.incidence * (np.linalg.norm(scene.points, axis=-1) - scene.ranges)
    # The arm stands at q + e where the model says q: the distances are short by what e would have added.
    errors = errors - np.einsum("nmj,nj->nm", workcell.by_joint, scene.q_true - scene.q)
    J = workcell.J.reshape(-1, workcell.J.shape[-1])
    moved = workcell.D @ np.linalg.lstsq(J, errors.ravel(), rcond=None)[0]
    assert found.position.mean() == pytest.approx(np.linalg.norm(moved[:, 3:], axis=1).mean(), rel=0.03)
    assert found.orientation.mean() == pytest.approx(np.linalg.norm(moved[:, :3], axis=1).mean(), rel=0.03)


def test_errors_scale_with_everything_that_makes_them(ensemble):
    """Half the noise and half of every effect halve every error."""
    sizes = Sizes(noise=2.0, shared=0.5, scan=4e-5, joint=6e-5)
    half = Sizes(noise=2.0, shared=0.5, scan=2e-5, joint=3e-5)
    whole = ensemble.log_errors(BASE, sizes)
    halved = ensemble.log_errors(Setting(**{**BASE.__dict__, "sigma": 5e-5}), half)
    assert np.allclose(whole - halved, np.log(2.0), atol=1e-4)


def test_shares_are_parts_of_a_whole(ensemble):
    """The shares of the effects sum to one, and a single effect has the share one."""
    assert ensemble.shares(BASE, Sizes(scan=1e-4, joint=1e-4, step=STEP)).sum() == pytest.approx(1.0)
    assert ensemble.shares(BASE, Sizes(noise=0.0, joint=1e-4)).tolist() == [0.0, 0.0, 1.0]


def test_the_solvers_path_goes_down_to_the_truth(workcell):
    """Without noise the cost never rises, the end is the truth, and a tighter tolerance never stops earlier."""
    guess = initial_planes(workcell, 0.01, 1.0, np.random.default_rng(0))
    path = follow(workcell, BASE.poses, guess, np.arange(50))
    assert (np.diff(path.excess) <= 1e-18).all()
    assert np.abs(path.left[-1]).max() < 1e-7
    assert np.abs(path.left[0]).max() > 1e-3
    stops = [stops_at(path, 1e-6, tolerance) for tolerance in (0.5, 1e-2, 1e-4, 1e-8)]
    assert stops == sorted(stops)


def test_a_stop_after_many_iterations_is_no_stop(ensemble):
    """The last iterate is the optimum, and the noise moves it as it moves a fit that was let run."""
    stopped = ensemble.log_errors(BASE, Sizes(iterations=39))
    assert np.allclose(stopped, ensemble.log_errors(BASE, Sizes())[: len(stopped)], atol=1e-3)


def synthetic(rng, runs=12, name="scan"):
    """Return a prediction that grows with its magnitude from a floor, as real ones do."""
    candidate = Candidate(name, name, (name,))
    nodes = candidate.nodes()
    noise = np.exp(rng.normal(size=(runs, 1)))
    mean = 0.5 * np.log(noise**2 + (nodes[:, 0, None, None] / 4e-5) ** 2) + np.array([0.0, 0.7, -1.5, -0.9])
    root = rng.normal(size=(runs, 4, 4)) * 0.1 + 0.3 * np.eye(4)
    covariance = np.broadcast_to(root @ root.swapaxes(1, 2), (len(nodes), runs, 4, 4))
    share = noise[:, 0] ** 2 / (noise[:, 0] ** 2 + (nodes / 4e-5) ** 2)
    return Prediction(candidate, nodes, mean, covariance, np.stack([share, 1 - share, 0 * share], axis=-1))


def dense_covariance(refined, node, kappa, offset):
    """Return the covariance of all values of all runs, written out."""
    runs, q = refined.mean.shape[1:]
    F = np.concatenate([np.kron(refined.shares[node, r], np.eye(q)) for r in range(runs)])
    whole = F @ offset @ F.T
    for r in range(runs):
        at = slice(q * r, q * r + q)
        whole[at, at] += kappa**2 * refined.covariance[node, r]
    return whole


def test_the_likelihood_is_the_normal_law():
    """The likelihood agrees with SciPy's density with the covariance written out, at some nodes and every kappa, for two sets."""
    rng = np.random.default_rng(5)
    refined = refine(synthetic(rng, runs=5))
    root = rng.normal(size=(12, 12)) * 0.2
    offset = root @ root.T + 0.01 * np.eye(12)
    y = rng.normal(size=(2, 5, 4))
    found = log_likelihood(refined, y, offset)
    for node in (0, 7, 20):
        for k, kappa in enumerate(KAPPA):
            law = multivariate_normal(
                refined.mean[node].ravel(), dense_covariance(refined, node, kappa, offset)
            )
            assert np.allclose(found[node, k], [law.logpdf(one.ravel()) for one in y], rtol=1e-8)


def test_the_offset_found_is_the_conditional_mean():
    """The offset agrees with the conditional mean of the joint normal distribution, written out."""
    rng = np.random.default_rng(6)
    refined = refine(synthetic(rng, runs=4))
    root = rng.normal(size=(12, 12)) * 0.2
    offset = root @ root.T + 0.01 * np.eye(12)
    y = rng.normal(size=(4, 4))
    F = np.concatenate([np.kron(refined.shares[9, r], np.eye(4)) for r in range(4)])
    weight = np.linalg.solve(dense_covariance(refined, 9, 1.0, offset), (y - refined.mean[9]).ravel())
    assert np.allclose(offsets_found(refined, 9, 1.0, y, offset).ravel(), F @ offset @ F.T @ weight)


def drawn(prediction, node, offset, sets, rng):
    """Return sets of curves from a prediction's own law."""
    refined = refine(prediction)
    at = int(np.argmin(np.abs(refined.nodes[:, 0] - prediction.nodes[node, 0])))
    whole = dense_covariance(refined, at, 1.0, offset)
    flat = rng.multivariate_normal(refined.mean[at].ravel(), whole, size=sets)
    return flat.reshape(sets, *refined.mean[at].shape), prediction.nodes[node]


def test_intervals_cover_and_the_injected_one_is_found():
    """With data from the model itself, 95 % intervals hold the truth in about 95 % of the sets."""
    rng = np.random.default_rng(7)
    there, offset = synthetic(rng), 0.01 * np.eye(12)
    none = Prediction(
        Candidate("stated", "none"), np.zeros((1, 0)), there.mean[:1], there.covariance[:1], there.shares[:1]
    )
    refined_by_name = {"scan": refine(there), "stated": refine(none)}
    curves, values = drawn(there, 4, offset, 200, rng)
    confusion, coverage = recover({"scan": (curves, values)}, refined_by_name, offset)
    shares = confusion.set_index("tried")
    assert shares.loc["scan", "best"] > 0.95
    assert shares.loc["stated", "excluded"] > 0.95
    assert 0.90 <= coverage.loc[0, "coverage_95"] <= 0.99
    assert 0.58 <= coverage.loc[0, "coverage_68"] <= 0.78


def test_a_candidate_that_is_not_there_is_not_found():
    """Curves of the stated noise alone do not exclude it, and bound the effect from above."""
    rng = np.random.default_rng(8)
    there, offset = synthetic(rng), 0.01 * np.eye(12)
    curves, _ = drawn(there, 0, offset, 40, rng)
    none = Prediction(
        Candidate("stated", "none"), np.zeros((1, 0)), there.mean[:1], there.covariance[:1], there.shares[:1]
    )
    with_it, without = (weigh(refine(p), curves, offset) for p in (there, none))
    behind = np.array([a.log_evidence - b.log_evidence for a, b in zip(with_it, without, strict=True)])
    assert (behind < 3.0).mean() > 0.95
    assert all(one.intervals[0.95][0, 1] < 4e-5 for one in with_it)


def test_curves_held_out_one_by_one_are_probabilities_given_the_rest():
    """For two curves, p(a | b) p(b) is p(a, b)."""
    rng = np.random.default_rng(9)
    refined, offset = refine(synthetic(rng, runs=6)), 0.04 * np.eye(12)
    y, groups = rng.normal(size=(6, 4)), np.array(["a"] * 3 + ["b"] * 3)
    apart = held_out(refined, y, offset, groups)
    alone = weigh(refined, y[None], offset, groups == "b")[0].log_evidence
    assert apart["a"] + alone == pytest.approx(weigh(refined, y[None], offset)[0].log_evidence)


def test_every_published_point_is_weighed_or_left_out_for_a_reason():
    """No published point is lost, the run that two sweeps share counts once, and runs with fifteen poses are left out."""
    table = pd.read_csv(SCENES.parents[1] / "workflow/resources/published_curves.csv")
    base = Setting(120, 100, 1e-4, 0.01, 1.0)
    curves = read_curves(table, base, {"poses": [18]}, 16)
    assert len(curves.table) + len(curves.left_out) == len(table)
    assert not curves.table.duplicated(list(QUANTITIES)).any()
    assert curves.left_out["reason"].nunique() == 3
    assert min(setting.poses for setting in curves.settings) == 21
    noise = [s.sigma for s, row in zip(curves.settings, curves.table["sweep"], strict=True) if row == "noise"]
    assert np.allclose(noise, [1e-3, 5e-4, 1e-4, 5e-5, 1e-5])


def test_the_same_seeds_give_the_same_predictions(ensemble):
    """The predictions are the same to the last bit, whatever was computed before."""
    candidates = [Candidate("scan", "scan", ("scan",)), Candidate("stated", "stated")]
    settings = [BASE, Setting(**{**BASE.__dict__, "sigma": 5e-5})]
    again = build_ensemble(scene_config(), SCENES, [1, 2, 3], 4, settings, [STEP], 2)
    again.log_errors(settings[1], Sizes(joint=1e-4, step=STEP))
    first, second = (predict(one, candidates, settings) for one in (ensemble, again))
    for name in first:
        assert np.array_equal(first[name].mean, second[name].mean)
        assert np.array_equal(first[name].covariance, second[name].covariance)


def test_rounding_of_equal_steps_is_what_the_simulator_rounds(workcell):
    """The unit shift of rounded ranges is of the size that fits to simulated rounded ranges show."""
    rng = np.random.default_rng(1)
    found = shifts(workcell, (BASE.poses, BASE.points), [1e-4], [STEP], 40, rng).rounded[1e-4, STEP]
    moved = np.einsum("pif,rf->rpi", workcell.D[:, 3:], found)
    ours = np.log(np.linalg.norm(moved, axis=-1).mean(axis=1))
    scene = simulate(scene_config(range_noise_std_m=1e-4, range_quantum_m=STEP), base_dir=SCENES)
    errors = workcell.incidence * (np.linalg.norm(scene.points, axis=-1) - scene.ranges)
    theirs = (
        workcell.D[:, 3:]
        @ np.linalg.lstsq(workcell.J.reshape(-1, workcell.J.shape[-1]), errors.ravel(), rcond=None)[0]
    )
    assert abs(np.log(np.linalg.norm(theirs, axis=1).mean()) - ours.mean()) < 4 * ours.std()


def test_evaluation_poses_are_the_simulators(workcell):
    """The frames that errors are counted from are those of truth_poses.csv."""
    at = Poses.from_frame(workcell.evaluated, workcell.dataset.robot.slides, order_is_row=False)
    assert len(at) == len(workcell.D)
    assert np.allclose(workcell.T_true, true_frames(workcell.evaluated), atol=1e-9)
