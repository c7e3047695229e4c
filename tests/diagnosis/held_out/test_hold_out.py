"""Held-out errors: every pose is predicted once, by a fit without its block."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scalar.data.dataset import Dataset
from scalar.diagnosis.fit.fitted_state import refit
from scalar.diagnosis.held_out.hold_out import (
    REGIONS,
    HeldOutErrors,
    blocks,
    blocks_of,
    held_out_errors,
    held_out_regions,
    improvement,
    improves_with_limited_blocks,
)
from scalar.diagnosis.held_out.repetitions import moving_joints
from scalar.diagnosis.settings import DEFAULTS
from scalar.effects.command_line import parse_effects
from scalar.estimation.geometry_fit import geometry_fit
from scalar.estimation.least_squares import fit
from scalar.estimation.residuals import Residuals
from tests.diagnosis.cases import scale
from tests.effects.injected import make_cell
from tests.random_scene import make_scene

FOLDS, BLOCKS_PER_FOLD = DEFAULTS.hold_out.folds, DEFAULTS.hold_out.blocks_per_fold


def fitted(dataset, effects=""):
    model, prepared = geometry_fit(dataset)
    return refit(dataset, model, prepared.free, parse_effects(effects, dataset))


@given(n=st.integers(1, 3000))
def test_every_pose_is_held_out_once_in_a_block(n):
    """Blocks are of successive poses, folds take them in turn, and no fold has more than its share."""
    block, fold = blocks(np.arange(n)[:, None] * np.array([1.0, -1.0]))
    assert len(block) == len(fold) == n
    assert np.all(np.diff(block) >= 0) and block[0] == 0 and np.all(np.diff(block) <= 1)
    assert np.all((fold >= 0) & (fold < FOLDS))
    sizes = np.bincount(block)
    assert sizes.max() - sizes.min() <= 1
    if n >= 2 * FOLDS * BLOCKS_PER_FOLD:
        shares = np.bincount(fold, minlength=FOLDS)
        assert shares.max() - shares.min() <= BLOCKS_PER_FOLD
        for f in range(FOLDS):  # every fold spans the run: no fold is one end of it
            assert np.ptp(np.flatnonzero(fold == f)) > 0.5 * n


@pytest.mark.parametrize("times", [2, 3, 7])
def test_repetitions_of_a_pose_are_held_out_together(times):
    """Repetitions of a pose, as encoders read them, are in the block of the first such pose; the blocks of first poses are those of a dataset without
    repetitions.
    """
    rng = np.random.default_rng(times)
    once = rng.uniform(-2, 2, (100, 6))
    again = np.concatenate([once] * times) + rng.uniform(-5e-4, 5e-4, (100 * times, 6))
    block, fold = blocks(again)
    expected, _ = blocks(once)
    np.testing.assert_array_equal(block, np.tile(expected, times))
    np.testing.assert_array_equal(fold, block % FOLDS)


@pytest.mark.parametrize("off_axis", [0.0, 0.05])
def test_turning_the_tool_about_its_own_axis_makes_no_other_pose(off_axis):
    """With a reflector on the last axis, five poses that differ in the last joint alone are held out together. With the reflector five centimetres
    off the axis they are five poses, and a block may end between them.
    """
    rng = np.random.default_rng(8)
    scene = make_scene(kind="tracker", seed=8, poses_per_plane=50).dataset
    q = np.repeat(scene.q[:29], 5, axis=0)
    q[:, 5] = rng.uniform(-2, 2, len(q))
    tool = np.array([off_axis, 0.0, 0.1])
    frames = scene.robot.flange(q)
    points = frames[:, :3, :3] @ tool + frames[:, :3, 3] + 1e-5 * rng.standard_normal((len(q), 3))
    T = np.eye(4)
    T[:3, 3] = tool
    sensor = replace(scene.sensor, T_flange_sensor=T)
    state = fitted(Dataset.from_arrays(name="turning", robot=scene.robot, sensor=sensor, q=q, points=points))
    assert list(moving_joints(state)) == [True] * 5 + [off_axis > 0]
    of_five = blocks_of(state)[0].reshape(-1, 5)
    assert np.all(of_five == of_five[:, :1]) == (off_axis == 0)


def test_the_step_is_a_refit_without_the_fold():
    """The errors of each fold are those of a model refitted to the other poses alone, within 2 %."""
    dataset = make_cell(seed=2, poses_per_plane=40, points_per_scan=20).dataset
    state = fitted(dataset)
    found = held_out_errors(state)
    _, fold = blocks(dataset.q)
    for f in range(2):
        train = fold != f
        part = dataset.subset(train)
        residuals = Residuals.of(part, state.model).reweighted(state.model)
        model = fit(residuals, state.model, state.free).model
        squares, counts = Residuals.of(dataset, model).squared_distances(model)
        np.testing.assert_allclose(
            np.sqrt(squares / counts)[~train], np.sqrt(found.metric)[~train], rtol=0.02
        )


def test_held_out_errors_exceed_the_fitted_ones_by_the_price_of_the_fit():
    """A fit of p parameters to n rows leaves less than the noise on these rows and more on new ones: the ratio of the squares is about (n + p) / (n -
    p).
    """
    dataset = make_cell(seed=3, poses_per_plane=40, points_per_scan=20).dataset
    state = fitted(dataset)
    rows, J = state.linearised()
    p, n = J.shape[1], int(np.count_nonzero(np.any(J != 0, axis=1)))
    ratio = held_out_errors(state).whitened.sum() / np.sum(rows**2)
    # A scan has three rows, of which the model moves two: p is spent on the latter.
    assert 1.0 < ratio < 1.6 * (n + p) / (n - p)


def test_each_region_is_predicted_by_a_fit_without_it():
    """Regions consist of similar poses, and each is predicted by least squares on the others."""
    dataset = make_cell(seed=5, poses_per_plane=30, points_per_scan=20).dataset
    state = fitted(dataset)
    found = held_out_regions(state)
    assert found is not None and len(np.unique(found.block)) == REGIONS
    widest = int(np.argmax(np.ptp(dataset.q, axis=0)))
    middle = [np.mean(dataset.q[found.block == k, widest]) for k in range(REGIONS)]
    assert np.ptp(middle) > np.ptp(dataset.q[:, widest]) / 3
    residual, J = state.linearised()
    m = state.residuals.measurement.rows_per_pose
    for region in (0, 5):
        out = np.repeat(found.block == region, m)
        step = np.linalg.lstsq(J[~out], -residual[~out], rcond=None)[0]
        left = (residual[out] + J[out] @ step).reshape(-1, m)
        np.testing.assert_allclose(found.whitened[found.block == region], np.sum(left**2, axis=1), rtol=1e-5)


def test_an_injected_effect_lowers_the_held_out_error():
    """The injected effect lowers the held-out error by many standard errors; an effect that was not injected does not."""
    cell, name, target = scale(4)
    without = held_out_errors(fitted(cell.dataset))
    right = held_out_errors(fitted(cell.dataset, f"{name}:{target['joint']}"))
    other = held_out_errors(fitted(cell.dataset, "joint_harmonic:4:19:23:29"))
    assert improvement(without, right) > 3
    assert improvement(without, other) < 2
    assert right.rms < without.rms


@pytest.mark.parametrize(("drop", "sign"), [(0.5, 1), (-0.5, -1), (0.0, 0)])
def test_improvement_counts_blocks(drop, sign):
    """The drop is measured in standard errors over blocks: equal drops of all blocks are significant, whatever their size."""
    block, _ = blocks(np.arange(80.0)[:, None])
    rng = np.random.default_rng(0)
    before = HeldOutErrors(rng.chisquare(3, 80), np.ones(80), np.ones(80), block)
    noise = 0.01 * rng.standard_normal(80)
    after = HeldOutErrors(before.whitened - drop + noise, np.ones(80), np.ones(80), block)
    assert (improvement(before, after) > 5) == (sign > 0)
    assert (improvement(before, after) < -5) == (sign < 0)


def test_one_block_that_gains_most_hides_no_others():
    """Nineteen blocks that gain alike are significant, whatever the twentieth gains; a large loss counts in full."""
    block = np.repeat(np.arange(20), 4)
    before, gain = np.full(80, 10.0), np.where(block == 7, 5000.0, 2.0) + np.tile([0.1, -0.1, 0.2, -0.2], 20)
    metric, counts = np.ones(80), np.ones(80)
    errors = [
        HeldOutErrors(whitened, metric, counts, block) for whitened in (before, before - gain, before + gain)
    ]
    assert improvement(errors[0], errors[1]) > 5
    assert improvement(errors[0], errors[2]) < 0
    lost = HeldOutErrors(before - np.where(block == 7, -5000.0, 2.0), metric, counts, block)
    assert improvement(errors[0], lost) < 0


@pytest.mark.parametrize(
    ("gaining", "lost", "in_metres", "gain"),
    [(18, 500.0, True, True), (18, 500.0, False, False), (8, 500.0, True, False), (18, 1.0, True, True)],
)
def test_no_single_block_decides_whether_most_gain(gaining, lost, in_metres, gain):
    """Eighteen of twenty blocks gain, and two lose whatever they lose; with eight it is otherwise. In metres errors have to fall as well."""
    before = np.full(20, 10.0)
    after = before + np.where(np.arange(20) < gaining, -1.0, lost)
    metres = after if in_metres else before + 1.0

    def errors(whitened, metric):
        return HeldOutErrors(whitened, metric, np.ones(20), np.arange(20))

    assert improves_with_limited_blocks(errors(before, before), errors(after, metres)) == gain


def test_poses_at_which_the_others_do_not_show_the_place_of_the_tracker_do_not_count():
    """A session has few poses away from the place of all its others: without them nothing shows how the tracker is turned."""
    dataset = make_scene("vs060", "tracker", poses_per_plane=20, noise=1e-4, seed=12).dataset
    both = dataset.subset(np.r_[np.arange(50), np.full(8, 50), 51, 52])
    rows = np.arange(both.n_poses)
    both = replace(
        both, poses=both.poses.assign(pose=rows, order=rows, session=np.where(rows < 50, "a", "b"))
    )
    model, prepared = geometry_fit(both)
    errors = held_out_errors(refit(both, model, prepared.free, ()))
    assert (errors.counts == 0).any() and not (errors.counts[:50] == 0).any()
    assert (errors.metric[errors.counts == 0] == 0).all() and errors.rms < 1e-3


@pytest.mark.parametrize(("poses", "counts"), [(2, False), (15, True)])
def test_poses_of_a_plane_that_the_others_do_not_show_do_not_count(poses, counts):
    """Two scans of the floor determine it together, and neither without the other; their errors say nothing of the arm, and do not count."""
    scene = make_scene(seed=5, poses_per_plane=30, points_per_scan=20, noise=1e-4)
    on_floor = np.cumsum(scene.dataset.plane_index == 0)
    dataset = scene.dataset.subset((scene.dataset.plane_index != 0) | (on_floor <= poses))
    errors = held_out_errors(fitted(dataset))
    mine = dataset.plane_index == 0
    assert np.all((errors.counts[mine] > 0) == counts) and np.all(errors.counts[~mine] > 0)
    assert errors.rms < 2e-4
