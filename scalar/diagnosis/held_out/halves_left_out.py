"""How far a model errs where nothing was measured: each half of the poses is predicted by the same model fitted to the other half.

Poses that are held out in blocks of successive poses have fitted poses on all sides. A user who goes beyond the measured poses has them on one side
only, and what a model lacks may grow there. The poses are therefore halved in every way in which a region may be missing: by the angle of each joint,
by the place of the flange along each axis of the base, and by the order of acquisition. The worst of the halves and their median are stated.

With the normal equations ``G`` of all poses and ``G_b`` of the poses left out, the refit without them is one Gauss-Newton step from the joint optimum
by ``G - G_b``; effects are fitted anew, and not chosen anew. In coordinates in which ``G`` is the identity, the eigenvalues of ``G - G_b`` are the
shares of the information that the other half has. A half that hardly determines a direction of the parameters may miss the truth by far, and so does
a calibration with such poses.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from scalar.diagnosis.fit.fitted_state import FittedState
from scalar.diagnosis.held_out.hold_out import in_metres
from scalar.diagnosis.held_out.repetitions import moving_joints
from scalar.estimation.design_effect import LEAST_POSES
from scalar.geometry.se3 import Array

_LEAST_OF_POSES = 0.25  # share of the poses in the smaller part: with less, equal values leave no halves
_LEAST_RANGE = 1e-3  # [rad or m] of a coordinate that divides the poses
# Directions of the parameters of which the data have less than this share of what they have of the best one, or of which the other half has less than
# this share of what all poses have, are not determined: they keep their values.
_LEAST_EIGENVALUE = 1e-9


@dataclass(frozen=True)
class HalfLeftOut:
    """A half of the poses, and the error of its predictions by a fit without it.

    Attributes:
        along: What divides the poses: ``q1`` to ``qn`` for the angle of a joint, ``x``, ``y`` or ``z`` for the place of the flange along an axis of
            the robot's base, ``order`` for the order of acquisition.
        upper: Whether it is the half with the larger values.
        poses: How many poses it has.
        rms: Root mean square distance of its points [m], noise of the measurement included.
        chance: The part of ``rms`` [m] that is expected because the other half determines the parameters with chance errors alone.
    """

    along: str
    upper: bool
    poses: int
    rms: float
    chance: float


@dataclass(frozen=True, eq=False)
class _Rows:
    """Rows of a fit to N poses in K coordinates of the parameters in which the normal equations of all poses are the identity.

    Attributes:
        whitened: ``(N, m, K)``, derivatives of the whitened residual.
        pulls: ``(N, K)``, derivatives of half the squared residual of each pose.
        total: ``(K,)``, derivatives of half the squared residual of all rows, those of priors included.
        in_metres: ``(N, k)`` [m], residual of the points.
        by_metres: ``(N, k, K)`` [m], its derivatives.
        counts: ``(N,)``, number of points.
        equations: ``(N,)``, number of equations.
        variance: Variance of the whitened residual.
    """

    whitened: Array
    pulls: Array
    total: Array
    in_metres: Array
    by_metres: Array
    counts: Array
    equations: Array
    variance: float

    @classmethod
    def of(cls, state: FittedState) -> _Rows:
        """Return the rows of a fit."""
        N, m = state.dataset.n_poses, state.residuals.measurement.rows_per_pose
        residual, J = state.linearised()
        to_unit = _to_unit_information(J)
        J = J @ to_unit
        whitened, of_poses = J[: N * m].reshape(N, m, -1), residual[: N * m].reshape(N, m)
        in_m, by_m = in_metres(state)
        equations = state.residuals.measurement.equations
        free = max(float(equations.sum()) - J.shape[1], 1.0)
        return cls(
            whitened,
            np.einsum("nmk,nm->nk", whitened, of_poses),
            J.T @ residual,
            in_m.reshape(N, -1),
            (by_m @ to_unit).reshape(N, -1, J.shape[1]),
            state.residuals.squared_distances(state.model)[1],
            equations,
            float(np.sum(of_poses**2)) / free,
        )

    def errors_without(self, out: Array) -> tuple[float, float]:
        """Return the root mean square distance [m] of the points of some poses ``(N,)`` by a fit without them, and its part by chance [m]."""
        rows = self.whitened[out].reshape(-1, self.whitened.shape[2])
        left_out, axes = np.linalg.eigh(rows.T @ rows)
        kept = 1.0 - left_out > _LEAST_EIGENVALUE
        axes, share = axes[:, kept], 1.0 - left_out[kept]
        step = -axes @ ((axes.T @ (self.total - self.pulls[out].sum(axis=0))) / share)
        moved = self.by_metres[out]
        n = float(self.counts[out].sum())
        by_chance = self.variance * float(np.sum((moved @ axes) ** 2 / share)) / n
        return float(np.sqrt(np.sum((self.in_metres[out] + moved @ step) ** 2) / n)), float(
            np.sqrt(by_chance)
        )


def halves_left_out(state: FittedState) -> list[HalfLeftOut]:
    """Return the halves of the poses of a fit, each predicted by a linearised refit without it, the worst first; they are computed once.

    There are none with fewer poses than two groups of similar poses need; halves whose complement has fewer equations than the model has free
    parameters are left out.

    Args:
        state: Model and data at the joint optimum; poses are weighted as in this fit.
    """
    return state.once(("halves left out",), lambda: _halves_left_out(state))


def _halves_left_out(state: FittedState) -> list[HalfLeftOut]:
    """Return the halves that ``halves_left_out`` returns, computed anew."""
    if state.dataset.n_poses < 2 * LEAST_POSES:
        return []
    rows, found = _Rows.of(state), []
    for along, upper in _divisions(state):
        for is_upper, out in ((True, upper), (False, ~upper)):
            if rows.equations[~out].sum() >= len(rows.total):
                found.append(HalfLeftOut(along, is_upper, int(out.sum()), *rows.errors_without(out)))
    return sorted(found, key=lambda half: -half.rms)


def _to_unit_information(J: Array) -> Array:
    """Return the matrix ``(F, K)`` by which the derivatives J ``(rows, F)`` have unit normal equations, in the K determined directions."""
    scale = np.linalg.norm(J, axis=0)
    scale[scale == 0] = 1.0
    values, axes = np.linalg.eigh((J / scale).T @ (J / scale))
    kept = values > _LEAST_EIGENVALUE * values[-1]
    return axes[:, kept] / np.sqrt(values[kept]) / scale[:, None]


def _divisions(state: FittedState) -> Iterator[tuple[str, Array]]:
    """Yield what divides the poses, and which poses ``(N,)`` have the larger values; each side has a quarter of the poses or more."""
    q, N = state.dataset.q, state.dataset.n_poses
    place = state.dataset.robot.flange(q)[:, :3, 3]
    along = {f"q{i + 1}": q[:, i] for i in np.flatnonzero(moving_joints(state))}
    along |= {axis: place[:, i] for i, axis in enumerate("xyz")} | {"order": np.arange(float(N))}
    for name, values in along.items():
        upper = _larger(values)
        if np.ptp(values) >= _LEAST_RANGE and _LEAST_OF_POSES <= upper.mean() <= 1.0 - _LEAST_OF_POSES:
            yield name, upper


def _larger(values: Array) -> Array:
    """Return which values ``(N,)`` are in the larger half; equal ones are on the same side, on that which leaves the sides more alike."""
    middle = np.median(values)
    sides = values > middle, values >= middle
    return min(sides, key=lambda upper: abs(float(upper.mean()) - 0.5))
