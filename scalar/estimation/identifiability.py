"""Identifiability: which directions of the model the measurements do not determine, and which parameters to fix because of them.

The Jacobian is taken for *perfect* measurements (``scalar.estimation.perfect_jacobian``). Axes within a few degrees of parallel are
taken as parallel: with such axes, plain DH can exchange d of one joint for d of the next with almost no residual, and the fit would run
away along that direction.

An undetermined direction has one of three causes: it is *structural* if no poses at all would determine it (the base, the flange, the scale); a
joint that stays *still* hides it; or *these poses* do not determine it and others would. The singular values are those of Hollerbach and Wampler
(1996); ``scalar.estimation.gauge_choice`` chooses what to fix.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg.lapack import dpotrf  # pyright: ignore[reportAttributeAccessIssue]  # made by f2py

from scalar.data.poses import Poses
from scalar.errors import Undetermined
from scalar.estimation.fixed_parameter import FixedParameter, explain
from scalar.estimation.gauge_choice import choose_fixed, preference
from scalar.estimation.model import Model
from scalar.estimation.perfect_jacobian import perfect_jacobian
from scalar.estimation.random_poses import joints_within
from scalar.estimation.residuals import Residuals
from scalar.estimation.settings import DEFAULTS, IdentifiabilitySettings
from scalar.geometry.parallel_axes import with_parallel_axes
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import Array

# Random poses within the limits: they give many more equations than there are parameters.
STRUCTURAL_POSES_PER_TARGET = 40
_ZERO_COLUMN = 1e-12  # of the largest column: no residual depends on a parameter whose column is shorter
_ROUNDING = 1e-13  # of the trace of J'J: some hundred times what rounding changes in a factor
_STRUCTURAL = 1e-5  # of a direction of unit length: a smaller part outside the structural null space is a rounding error


@dataclass(frozen=True, eq=False)
class Identifiability:
    """Which directions of a model the poses determine, by singular value decomposition.

    Attributes:
        names: ``(C,)``, the candidates: parameters that would be free if the data determined them.
        singular_values: ``(C,)``, of the column-scaled Jacobian at the poses, descending, the largest being 1.
        null_directions: ``(r, C)``, one for each fixed parameter, in the parameters' own units, that parameter's component being 1.
        n_structural: Number of the null directions that no poses at all would determine.
        fixed: ``(r,)``, the parameters to fix.
        n_left_to_priors: Number of further directions that these poses do not determine; their parameters stay free, and priors determine them.
    """

    names: tuple[str, ...]
    singular_values: Array
    null_directions: Array
    n_structural: int
    fixed: tuple[FixedParameter, ...]
    n_left_to_priors: int = 0

    @property
    def n_null(self) -> int:
        """Return the number of null directions at these poses."""
        return len(self.null_directions)

    @property
    def fixed_names(self) -> tuple[str, ...]:
        """Return the names of the parameters to fix."""
        return tuple(one.name for one in self.fixed)

    def sentences(self) -> list[str]:
        """Return which parameters are fixed and why, a sentence each."""
        return [f"{one.name} is fixed: {one.reason}." for one in self.fixed]


def analyse(
    residuals: Residuals,
    model: Model,
    candidates: Array,
    settings: IdentifiabilitySettings = DEFAULTS.identifiability,
    *,
    gauge_alone: bool = False,
) -> Identifiability:
    """Return which directions the poses of a dataset do not determine, and which parameters to fix because of them.

    Args:
        residuals: Of the dataset.
        model: Where the Jacobian is taken; its target should fit the data roughly. Its effects are left out.
        candidates: ``(P,)`` bool over robot, sensor and target: what would be free if the data determined it.
        settings: Thresholds.
        gauge_alone: Whether to fix parameters only for directions that are structural or hidden by still joints. The directions that
            only these poses leave open then stay free, because priors determine them.

    Raises:
        Undetermined: No pose reaches its target.
    """
    tolerance = settings.null_tolerance
    ideal = replace(model, robot=with_parallel_axes(model.robot), effects=()).rebased()
    measurement, poses = residuals.measurement, residuals.poses
    still = np.ptp(poses.q, axis=0) < settings.still
    if still.any():
        poses = _at_rest(poses.q, still, np.median(poses.q[:, still], axis=0))
    J = perfect_jacobian(residuals, measurement, ideal, poses, measurement.target_index)[:, candidates]
    if not len(J):
        raise Undetermined(
            ["no pose reaches its target with the geometry that was found, so that nothing can be determined there: "
             "check the nominal robot and the sensor's nominal pose, and measure more poses"]
        )  # fmt: skip
    names = tuple(name for name, wanted in zip(ideal.names, candidates, strict=True) if wanted)
    scale, values, null, factor = _null_space(J, tolerance)
    anywhere, index_any = _any_poses(ideal.robot, int(measurement.target_index.max()) + 1)
    J_any = perfect_jacobian(residuals, measurement, ideal, anywhere, index_any)[:, candidates]
    structural = _null_space_within(J_any / scale, null, tolerance)
    J_still, hidden_by_still = J_any, structural
    if still.any():
        anywhere = _at_rest(anywhere.q, still, poses.q[0, still])
        J_still = perfect_jacobian(residuals, measurement, ideal, anywhere, index_any)[:, candidates]
        hidden_by_still = _null_space_of_scaled(J_still / scale, tolerance)[1]
    n_left_to_priors = 0
    if gauge_alone and hidden_by_still.shape[1] < null.shape[1]:
        n_left_to_priors = null.shape[1] - hidden_by_still.shape[1]
        null, factor = hidden_by_still, np.asarray(np.linalg.qr(J_still / scale, mode="r"))
    chosen = choose_fixed(null, preference(ideal.robot, names), factor, settings)
    directions = np.zeros((0, len(names)))
    if chosen:
        directions = np.linalg.solve(null[chosen].T, null.T) / scale * scale[chosen][:, None]
    scaled = directions * scale
    scaled /= np.linalg.norm(scaled, axis=1, keepdims=True)
    cause = np.full(len(scaled), "poses", dtype=object)
    for name, space in (("still", hidden_by_still), ("structural", structural)):
        cause[np.linalg.norm(scaled - scaled @ space @ space.T, axis=1) < _STRUCTURAL] = name
    still_joints = [int(i) + 1 for i in np.flatnonzero(still)]
    values_at = dict(zip(ideal.names, ideal.vector, strict=True))
    fixed_names = {names[i] for i in chosen}
    others = {k: v for k, v in values_at.items() if k not in fixed_names}
    own = [others | {names[i]: values_at[names[i]]} for i in chosen]
    fixed = tuple(
        explain(names, index, direction, still_joints, values, str(why), ideal.robot.prismatic)
        for index, direction, values, why in zip(chosen, directions, own, cause, strict=True)
    )
    return Identifiability(names, values, directions, structural.shape[1], fixed, n_left_to_priors)


def _at_rest(q: Array, still: Array, angles: Array) -> Poses:
    """Return poses with other angles of the joints that are still ``(n,)`` bool, the same at all poses."""
    q = q.copy()
    q[:, still] = angles
    return Poses.of_joints(q)


def _any_poses(robot: Robot, n_targets: int) -> tuple[Poses, Array]:
    """Return random poses within the limits, and a target for each; they are the same for every dataset of a robot."""
    count = STRUCTURAL_POSES_PER_TARGET * n_targets
    return joints_within(robot.limits, count, seed=0), np.arange(count) % n_targets


def _null_space(J: Array, tolerance: float) -> tuple[Array, Array, Array, Array]:
    """Return the column scales ``(C,)``, the scaled singular values ``(C,)``, an orthonormal null space ``(C, r)`` and the triangular factor."""
    scale = np.linalg.norm(J, axis=0)
    dead = scale <= _ZERO_COLUMN * scale.max(initial=0.0)
    scale = np.where(dead, 1.0, scale)
    return scale, *_null_space_of_scaled(np.where(dead, 0.0, J / scale), tolerance)


def _null_space_of_scaled(J: Array, tolerance: float) -> tuple[Array, Array, Array]:
    """Return singular values over the largest ``(F,)``, the directions ``(F, r)`` of those below the tolerance, and the factor R of J.

    Args:
        J: ``(rows, F)``, columns of unit length.
        tolerance: Relative singular value below which a direction is not observable.
    """
    factor = np.asarray(np.linalg.qr(J, mode="r"))
    _, s, Vt = np.linalg.svd(factor, full_matrices=True)
    values = np.zeros(J.shape[1])
    if len(s):
        values[: len(s)] = s / s[0]
    return values, Vt[values < tolerance].T, factor


def _null_space_within(J: Array, space: Array, tolerance: float) -> Array:
    """Return the null space ``(C, r)`` of a scaled Jacobian ``(rows, C)``, which most likely is a part of another space ``(C, s)``.

    Within that space it follows from the few singular values there, and a Cholesky factor proves that nothing of it lies outside, in a tenth of the
    time that all singular values take. All singular values are computed if one of the few is near the tolerance, or if the proof fails.
    """
    gram = J.T @ J
    total = float(np.trace(gram))
    # The square of the largest singular value lies between that of the longest column and the sum of all of them.
    least, most = tolerance**2 * float(gram.diagonal().max(initial=0.0)), tolerance**2 * total
    _, s, Vt = np.linalg.svd(J @ space, full_matrices=False)
    if J.shape[0] >= space.shape[1] and not np.any((s**2 > least / 4) & (s**2 < 4 * most)):
        found = space @ Vt[s**2 < least].T
        lifted = gram + total * (found @ found.T)
        lifted[np.diag_indices_from(lifted)] -= max(4 * most, _ROUNDING * total)
        if total > 0 and dpotrf(lifted)[1] == 0:
            return found
    return _null_space_of_scaled(J, tolerance)[1]
