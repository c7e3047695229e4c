"""A warm-up that starts anew after each stop: its equation, the records on which it is tried, and what a calibration makes of it."""

import json
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from scalar.effects.command_line import parse_effects
from scalar.effects.restarted_warm_up import RestartedWarmUp
from scalar.effects.saving import effect_from_mapping, effect_to_mapping
from scalar.effects.stretches import stretches_of_work
from scalar.errors import InvalidInput
from scalar.estimation.calibrate import calibrate
from tests.effects.injected import A, D, Flaws, PoseData, make_cell
from tests.random_scene import make_scene

GROWTH, CONSTANT = 5e-4, 100.0  # m/m, s
STOP = 400.0  # s


def recorded(n_stops, stop=STOP):
    """Return the columns of a run with pauses: a time that jumps."""

    def columns(rng, n_poses, n_joints):
        worked = np.cumsum(rng.uniform(5.0, 15.0, n_poses))
        return {"time": worked + stop * (np.arange(n_poses) * (n_stops + 1) // n_poses)}

    return columns


@pytest.fixture(scope="module")
def plain():
    """Return a small dataset without a time."""
    return make_scene(seed=5, poses_per_plane=20, points_per_scan=4).dataset


def with_columns(dataset, **columns):
    """Return a dataset with further columns of poses.csv."""
    return replace(dataset, poses=dataset.poses.assign(**columns))


@pytest.mark.parametrize("cooling", [0.4, 1.0, 3.0])
def test_the_warmth_solves_its_differential_equation(cooling):
    """The warmth agrees with SciPy's integrator: it tends towards 1 at work and towards 0 at rest, stretch after stretch."""
    begins, ends = (10.0, 300.0, 420.0), (200.0, 350.0, 600.0)
    effect = RestartedWarmUp("time", begins, ends, 80.0, cooling)
    edges = [10.0, 200.0, 300.0, 350.0, 420.0, 900.0]  # work and rest in turns
    state, x, expected = 0.0, [], []
    for k, (start, end) in enumerate(pairwise(edges)):
        at = np.linspace(start, end, 7)[:-1]
        slope = (lambda t, w: (1.0 - w) / 80.0) if k % 2 == 0 else (lambda t, w: -w / (80.0 * cooling))
        found = solve_ivp(slope, (start, end), [state], t_eval=[*at, end], rtol=1e-10, atol=1e-12).y[0]
        x, expected, state = [*x, *at], [*expected, *found[:-1]], found[-1]
    np.testing.assert_allclose(effect.warmth(np.array(x))[:, 0], expected, atol=1e-8)
    assert effect.warmth(np.array([0.0]))[0, 0] == 0.0


def test_without_cooling_time_every_stretch_starts_cold():
    """A cooling of zero means that nothing is left of the warmth after a stop."""
    effect = RestartedWarmUp("order", (0.0, 50.0), (49.0, 99.0), 20.0, 0.0)
    order = np.arange(50.0)
    np.testing.assert_array_equal(effect.warmth(order + 50.0), effect.warmth(order))


def test_gaps_in_time_are_stops(plain):
    """A pause of many usual intervals separates two stretches of work; evenly spread poses have none."""
    time = recorded(2)(np.random.default_rng(3), plain.n_poses, 6)["time"]
    by, stretches = stretches_of_work(with_columns(plain, time=time))
    assert by == "time"
    assert stretches == [(time[k], time[k + 19]) for k in (0, 20, 40)]
    assert not stretches_of_work(with_columns(plain, time=time - STOP * (np.arange(60) // 20)))[1]


def test_sessions_are_stretches_where_no_time_is_recorded_or_it_starts_again(plain):
    """If no time is recorded, sessions that follow one another by the order of poses are stretches of work; sessions that alternate show no stops."""
    session = np.repeat(["a", "b", "c"], 20)
    expected = ("order", [(0.0, 19.0), (20.0, 39.0), (40.0, 59.0)])
    assert stretches_of_work(with_columns(plain, session=session)) == expected
    again = with_columns(plain, session=session, time=np.tile(np.arange(20.0), 3))
    assert stretches_of_work(again) == expected
    assert not stretches_of_work(with_columns(plain, session=np.tile(["a", "b"], 30)))[1]


def test_it_is_tried_only_where_the_record_has_stops(plain):
    """The effect is no candidate without time and sessions, with an even time, or with a stop after the first few poses only."""
    even, early = np.arange(60.0), np.arange(60.0) + 1e4 * (np.arange(60) >= 3)
    for data in (plain, with_columns(plain, time=even), with_columns(plain, time=early)):
        assert not RestartedWarmUp.candidates(data)
        with pytest.raises(InvalidInput, match="no stop"):
            parse_effects("restarted_warm_up", data)
    assert RestartedWarmUp.candidates(with_columns(plain, time=even + 1e4 * (even >= 30)))


@pytest.fixture(scope="module")
def fitted():
    """Return the calibration of a noise-free arm that warms up three times, and its workcell."""
    truth = make_cell(seed=27, poses_per_plane=4).scene.truth
    lengths = np.zeros_like(truth.geometry)
    lengths[[A, D]] = truth.geometry[[A, D]]

    def growth(at: PoseData) -> np.ndarray:
        time = at.columns["time"]
        starts = time[np.diff(time, prepend=-1e9) > 60.0]
        since = time - starts[np.searchsorted(starts, time, side="right") - 1]
        return GROWTH * (1 - np.exp(-since / CONSTANT))[:, None, None] * lengths  # cold at each start

    cell = make_cell(
        Flaws(geometry=growth), seed=27, noise=0.0, stated_noise=1e-7, poses_per_plane=40, points_per_scan=12,
        columns=recorded(2, 1e5), length_error=0.0, angle_error=0.0,
    )  # fmt: skip
    (candidate,) = parse_effects("restarted_warm_up:time", cell.dataset)
    return calibrate(cell.dataset, effects=(replace(candidate, time_constant=CONSTANT),)), cell


def test_the_growth_comes_back_and_nothing_is_left(fitted):
    """Noise-free data of an arm that starts cold three times are explained to the last digit."""
    calibration, _ = fitted
    assert calibration.residual_rms < 2e-8
    assert calibration.model.effects[0].coefficients[0] == pytest.approx(GROWTH, rel=1e-5)


def test_predictions_reproduce_the_fit(fitted):
    """The sensor that ``predict`` gives at the measured poses lies on the fitted planes with every scan, also after saving and reading."""
    calibration, cell = fitted
    dataset, model = cell.dataset, calibration.model
    saved = json.loads(json.dumps(effect_to_mapping(model.effects[0], [None])))
    read = replace(calibration, model=replace(model, effects=(effect_from_mapping(saved),)))
    T = read.predict(dataset.poses)
    owner = np.repeat(np.arange(dataset.n_poses), np.diff(dataset.starts))
    x, z = dataset.points.T
    p = T[owner, :3, 3] + T[owner, :3, 0] * x[:, None] + T[owner, :3, 2] * z[:, None]
    normals, distances = model.target.normals, model.target.distances
    heights = (
        np.einsum("pi,pi->p", normals[dataset.plane_index[owner]], p) - distances[dataset.plane_index[owner]]
    )
    assert np.abs(heights).max() < 1e-7
    with pytest.raises(InvalidInput, match="time"):
        read.predict(dataset.poses.drop(columns=["time"]))
