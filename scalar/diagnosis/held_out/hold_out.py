"""Held-out errors: how well a model predicts poses that took no part in its fit, in blocks of successive poses.

Forward selection chooses effects by these errors, so they are somewhat too small for a model that was selected; ``outer_split`` estimates errors on
poses that took no part in the selection either. Residuals of neighbours in time are correlated, so a pose next to a training pose is hardly
independent of it. Poses are therefore divided into blocks in the order of acquisition. The blocks are assigned to the folds in turn, so that every
fold spans the whole time and a change at any time has poses of every fold on both sides. Repetitions of a pose are held out together, because an
error that belongs to the pose repeats with it. Poses that differ only in joints that move nothing that is measured (the last joint, if the reflector
is on its axis) are repetitions as well. The fit without a fold is one Gauss-Newton step from the joint optimum, which is accurate as long as the
model is nearly linear over that step.

Errors at poses near those of the fit say little about other poses. Whole regions of the joint space are therefore held out as well: a model that
predicts a region well although no pose of it took part in the fit extrapolates.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from scalar.diagnosis.fit.fitted_state import FittedState, whitened
from scalar.diagnosis.held_out.repetitions import first_of_repetitions, moving_joints
from scalar.diagnosis.held_out.shown_places import places_shown
from scalar.diagnosis.settings import DEFAULTS, HoldOutSettings
from scalar.estimation.design_effect import LEAST_POSES, similar_poses
from scalar.estimation.normal_equations import factor_if_conditioned, solved_by
from scalar.estimation.residuals import Residuals
from scalar.geometry.se3 import Array

# Number of regions of the joint space, by halving it three times. Smaller regions would have others on all sides, so that their errors would not
# show how a model extrapolates.
REGIONS = 8
# Normal equations lose too many digits if their least eigenvalue is a smaller share of the largest; below this condition number they do not.
_LEAST_EIGENVALUE = 1e-10
_CLEARLY_CONDITIONED = 1e8
_FEW_OF_PLANE = 10  # chosen: poses of a plane, of which three determine where it is unless they lie on a line


@dataclass(frozen=True, eq=False)
class HeldOutErrors:
    """Errors at N poses that were held out from the fit.

    Attributes:
        whitened: ``(N,)``, squared whitened residual of each pose.
        metric: ``(N,)`` [m^2], mean squared distance of each pose's points.
        counts: ``(N,)``, number of points of each pose; 0 of one that says nothing of the arm (``shown_places``), whose errors are 0 as well.
        block: ``(N,)``, index of each pose's block, or of its region.
        settings: Thresholds.
    """

    whitened: Array
    metric: Array
    counts: Array
    block: Array
    settings: HoldOutSettings = DEFAULTS.hold_out

    @property
    def rms(self) -> float:
        """Return the root mean square distance [m] over all points."""
        return float(np.sqrt(np.sum(self.metric * self.counts) / np.sum(self.counts)))

    @property
    def largest(self) -> float:
        """Return the largest root mean square distance of a pose [m]."""
        return float(np.sqrt(np.max(self.metric)))


def blocks(q: Array, settings: HoldOutSettings = DEFAULTS.hold_out) -> tuple[Array, Array]:
    """Return the block ``(N,)`` and the fold ``(N,)`` of every pose; a repetition belongs to the block of the pose that it repeats.

    Args:
        q: Joint coordinates ``(N, n)`` [rad, or m of a joint that slides] in the order of acquisition.
        settings: Thresholds.
    """
    first = first_of_repetitions(q, settings.same_pose)
    new = first == np.arange(len(q))
    n_new = int(new.sum())
    n_blocks = max(min(settings.folds * settings.blocks_per_fold, n_new // 2), 1)
    count = np.cumsum(new) - 1
    block = (count * n_blocks // n_new)[first]
    return block, block % settings.folds


def blocks_of(state: FittedState) -> tuple[Array, Array]:
    """Return the block ``(N,)`` and the fold ``(N,)`` of every pose of a state; only joints that move what is measured distinguish poses."""
    moving, settings = moving_joints(state), state.settings.hold_out
    return state.rows.once(
        ("blocks", settings, *moving.tolist()), lambda: blocks(state.dataset.q[:, moving], settings)
    )


def held_out_errors(state: FittedState, whitening: Array | None = None) -> HeldOutErrors:
    """Return the held-out errors of a state, every pose held out once; they are computed once for each whitening.

    Args:
        state: Model and data at the joint optimum.
        whitening: ``(N, m, m)``, for a variance component of whole poses, or None. States that are compared need the same whitening.
    """
    key = id(whitening)
    if key not in state.held_out:
        block, fold = blocks_of(state)
        state.held_out[key] = whitening, _held_out_errors(state, whitening, block, fold)[0]
    return state.held_out[key][1]


def held_out_errors_without(
    state: FittedState, coefficients: Sequence[Array], whitening: Array | None = None
) -> list[HeldOutErrors]:
    """Return the held-out errors of the model without some coefficients of its effects, once for each set of them, by linear fits about the state.

    Nothing is refitted, so the errors are those of a refit where the model is linear and the noise and the weight of the priors stay the same.

    Args:
        state: Model and data at the joint optimum.
        coefficients: The indices of the coefficients that are left out, among those of all effects.
        whitening: ``(N, m, m)``, for a variance component of whole poses, or None.
    """
    block, fold = blocks_of(state)
    parameters = np.flatnonzero(state.free)
    first = len(state.free) - sum(len(effect.coefficients) for effect in state.effects)
    columns = [np.flatnonzero(np.isin(parameters, first + np.asarray(left_out))) for left_out in coefficients]
    return _held_out_errors(state, whitening, block, fold, columns)


def held_out_regions(state: FittedState, whitening: Array | None = None) -> HeldOutErrors | None:
    """Return the errors where each of up to eight regions of the joint space is held out as a whole; None with too few poses for two regions.

    Args:
        state: Model and data at the joint optimum.
        whitening: ``(N, m, m)``, for a variance component of whole poses, or None.
    """
    region = similar_poses(state.dataset.q[:, moving_joints(state)], REGIONS, LEAST_POSES)
    return _held_out_errors(state, whitening, region, region)[0] if region.any() else None


def _held_out_errors(
    state: FittedState,
    whitening: Array | None,
    block: Array,
    fold: Array,
    left_out: Sequence[Array] = (np.zeros(0, dtype=int),),
) -> list[HeldOutErrors]:
    """Return the errors of the poses of each fold by a fit without them, for each set of columns that the model does without.

    Args:
        state: Model and data at the joint optimum.
        whitening: ``(N, m, m)``, or None.
        block: ``(N,)``, the block of each pose; it is kept with the errors.
        fold: ``(N,)``, the fold of each pose.
        left_out: Sets of indices of the F free parameters; these parameters are zero instead.
    """
    residual, J = (whitened(whitening, rows) for rows in state.linearised())
    N, m = state.dataset.n_poses, state.residuals.measurement.rows_per_pose
    r_metric, J_metric = in_metres(state)
    m_metric = len(r_metric) // N
    scale = np.linalg.norm(J, axis=0)
    scale[scale == 0] = 1.0
    gram, projection = J.T @ J / np.outer(scale, scale), J.T @ residual / scale
    whitened_squares, squares = np.zeros((len(left_out), N)), np.zeros((len(left_out), N))
    # Steps [units of ``scale``] that set the parameters of each set to zero.
    to_zero = [-(state.model.vector[state.free][columns]) * scale[columns] for columns in left_out]
    kept = [np.setdiff1d(np.arange(len(scale)), columns) for columns in left_out]
    for f in np.unique(fold):
        out = fold == f
        test, test_metric = np.repeat(out, m), np.repeat(out, m_metric)
        J_test = J[: N * m][test]
        scaled = J_test / scale
        # The normal equations of the other folds, by subtraction.
        G = gram - scaled.T @ scaled
        g = projection - scaled.T @ residual[: N * m][test]
        for i, (columns, others) in enumerate(zip(left_out, kept, strict=True)):
            step = np.zeros(len(scale))
            step[columns] = to_zero[i]
            rest = _step(G[np.ix_(others, others)], (g + G[:, columns] @ to_zero[i])[others])
            if rest is None:
                train = np.r_[~test, np.ones(len(residual) - N * m, dtype=bool)]
                moved = residual[train] + (J[train][:, columns] / scale[columns]) @ to_zero[i]
                rest = -np.linalg.lstsq(J[train][:, others] / scale[others], moved, rcond=1e-8)[0]
            step[others] = rest
            step = step / scale
            errors = (residual[: N * m][test] + J_test @ step).reshape(-1, m)
            whitened_squares[i, out] = np.sum(errors**2, axis=1)
            errors = (r_metric[test_metric] + J_metric[test_metric] @ step).reshape(-1, m_metric)
            squares[i, out] = np.sum(errors**2, axis=1)
    counts = state.once(("points of each pose",), lambda: state.residuals.squared_distances(state.model)[1])
    hidden = _without_place(state, J, fold)
    if hidden.any() and not hidden.all():
        counts = np.where(hidden, 0, counts)
        whitened_squares[:, hidden] = squares[:, hidden] = 0.0
    settings = state.settings.hold_out
    return [
        HeldOutErrors(of_rows, of_points / np.maximum(counts, 1), counts, block, settings)
        for of_rows, of_points in zip(whitened_squares, squares, strict=True)
    ]


def _without_place(state: FittedState, J: Array, fold: Array) -> Array:
    """Return at which poses ``(N,)`` bool the other folds do not show where the tracker or the plane stood.

    There are none where all poses have one place of the tracker, nor where every plane has at least ``_FEW_OF_PLANE`` poses in the other folds.

    Args:
        state: Model and data at the joint optimum.
        J: ``(rows, F)``, the derivatives of the whitened residuals by its free parameters.
        fold: ``(N,)``, the fold of each pose.
    """
    dataset, hidden = state.dataset, np.zeros(len(fold), dtype=bool)
    if dataset.planes:
        poses_of = np.unique(dataset.plane_index, return_inverse=True)[1]
        of_fold = np.zeros((int(fold.max()) + 1, int(poses_of.max()) + 1), dtype=int)
        np.add.at(of_fold, (fold, poses_of), 1)
        if np.min(of_fold.sum(axis=0) - of_fold) >= _FEW_OF_PLANE:
            return hidden
    elif dataset.session is None:
        return hidden
    of_target = state.model.blocks["target"]
    free = np.flatnonzero(state.free)
    J_target = J[:, (free >= of_target.start) & (free < of_target.stop)]
    J_target = J_target[: len(fold) * state.residuals.measurement.rows_per_pose].reshape(
        len(fold), -1, J_target.shape[1]
    )
    for f in np.unique(fold):
        hidden |= (fold == f) & ~places_shown(J_target, fold != f)
    return hidden


def _step(gram: Array, projection: Array) -> Array | None:
    """Return the Gauss-Newton step by normal equations if these are well conditioned, else None."""
    factor = factor_if_conditioned(gram, _CLEARLY_CONDITIONED)
    if factor is not None:
        return -solved_by(factor, projection)
    values = np.linalg.eigvalsh(gram)
    if values[0] > _LEAST_EIGENVALUE * values[-1]:
        return -np.linalg.solve(gram, projection)
    return None


def in_metres(state: FittedState) -> tuple[Array, Array]:
    """Return the rows of the poses in metres, every point with the same weight, and their derivatives by the free parameters [m]."""

    def measured_in_metres() -> tuple[Residuals, float]:
        measurement, metres = state.residuals.measurement.in_metres()
        return state.residuals.measured_as(measurement, state.model), metres

    rows, metres = state.once(("rows in metres",), measured_in_metres)
    residual, J = rows.linearise_measured(state.model)
    return residual * metres, J.take(np.flatnonzero(state.free), axis=1) * metres


def improvement(before: HeldOutErrors, after: HeldOutErrors) -> float:
    """Return by how many standard errors the squared whitened held-out error falls; blocks are the independent samples.

    One block that the other poses hardly determine may gain more than all others together, and its scatter then hides their gain. The fall is
    therefore also computed with the gain of each block limited to ``most_gain_of_block`` times the median change of a block, while losses count in
    full. In this, the squared error of a pose is limited to ``most_of_pose`` times the median before: a supposed random error of the joints moves an
    arm that is stretched out only across it, and the weight of its error along the arm may exceed that of all other poses together. The larger of
    the two numbers is returned.
    """
    n = int(before.block.max()) + 1
    per_block = np.bincount(before.block, weights=before.whitened - after.whitened, minlength=n)
    most = before.settings.most_of_pose * float(np.median(before.whitened))
    limited = np.minimum(before.whitened, most) - np.minimum(after.whitened, most)
    usual = np.bincount(before.block, weights=limited, minlength=n)
    usual = np.minimum(usual, before.settings.most_gain_of_block * float(np.median(np.abs(usual))))
    return max(_in_standard_errors(per_block), _in_standard_errors(usual))


def improves_with_limited_blocks(before: HeldOutErrors, after: HeldOutErrors) -> bool:
    """Return whether held-out errors fall if the change of each block counts for at most ``most_gain_of_block`` times that of the median block.

    No single block can decide then, for or against: unlike in ``improvement``, losses are limited as well. If a plane is knocked after four of its
    scans, for example, and the block that is held out contains three of them, these are predicted from a single scan: that loss is no evidence
    against the knock. The sum of the limited changes has to be a fall both for the whitened errors and for those in metres.
    """

    def falls(drops: Array) -> bool:
        per_block = np.bincount(before.block, weights=drops)
        most = before.settings.most_gain_of_block * float(np.median(np.abs(per_block)))
        return bool(np.clip(per_block, -most, most).sum() > 0)

    return falls(before.whitened - after.whitened) and falls(before.metric - after.metric)


def _in_standard_errors(drops: Array) -> float:
    """Return the sum of the drops of blocks over its standard error."""
    n = len(drops)
    error = float(np.std(drops, ddof=1)) * np.sqrt(n) if n > 1 else 0.0
    total = float(drops.sum())
    return total / error if error > 0 else (np.inf if total > 0 else 0.0)


def no_worse(before: HeldOutErrors, after: HeldOutErrors) -> bool:
    """Return whether the held-out error in metres grows by no more than ``tolerated_growth``.

    This is required in addition to ``improvement``, because an improvement of weighted rows alone may not hold at other poses.
    """
    return after.rms <= (1.0 + before.settings.tolerated_growth) * before.rms
