"""The variance of predictions at poses that were not measured, by leaving out one pose at a time; it is used to compare weights of the poses.

The delete-one-pose jackknife (Efron and Stein, Annals of Statistics 9, 1981; CR3 of Bell and McCaffrey, Survey Methodology 28, 2002) is valid
for any covariance within a pose, even if the weights of a fit are wrong. A fit with the weights of a component that does not exist loses
efficiency but is not biased; its own standard errors do not show this loss, whereas the jackknife does.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from scalar.data.poses import Poses
from scalar.diagnosis.fitted_state import FittedState, whitened
from scalar.diagnosis.harmonic_spectrum import as_whitened
from scalar.diagnosis.predicted_displacements import (
    displacement_columns,
    joint_limits,
    measured_ranges,
    poses_measured,
    poses_within,
)
from scalar.geometry.se3 import Array

N_POSES = 200  # random poses at which predictions are compared
_LEAST_LEFT = 1e-3  # least share of a pose's rows that the fit leaves; it limits the inflation for a pose that alone determines a direction


@dataclass(frozen=True, eq=False)
class Moves:
    """How predicted positions at random poses move, the best rigid motion removed.

    Attributes:
        to_optimum: ``(3 K,)`` [m], from the state to the optimum under the weights.
        left_out: ``(N, 3 K)`` [m], when each pose is left out of the fit.
    """

    to_optimum: Array
    left_out: Array

    @property
    def std(self) -> float:
        """Return the standard error of a predicted position [m], root mean square over the random poses."""
        return _standard_error(self.left_out)

    def apart(self, other: Moves) -> tuple[float, float]:
        """Return by how much two fits of the same poses differ in their predictions [m], and the standard error of that difference [m]."""
        difference = self.to_optimum - other.to_optimum
        return _length(difference), _standard_error(self.left_out - other.left_out)


class Linearised:
    """A state, linearised at its optimum: fits with some of its coordinates free, and of all poses but one.

    Attributes:
        coefficients: ``(F,)``, the free coordinates, times ``scale``.
        scale: ``(F,)``, the lengths of the Jacobian's columns.
    """

    def __init__(self, state: FittedState, whitening: Array | None):
        """Linearise.

        Args:
            state: Near the optimum.
            whitening: ``(N, m, m)``, the weights of the poses; None for those of the noise within scans alone.
        """
        residual, J = (whitened(whitening, rows) for rows in state.linearised())
        self._poses = state.dataset.n_poses, state.residuals.measurement.rows_per_pose
        self.scale = np.linalg.norm(J, axis=0)
        self.scale[self.scale == 0] = 1.0
        self._residual, self._J = residual, J / self.scale
        self._gram, self._projection = self._J.T @ self._J, self._J.T @ residual
        self._state = state
        self.coefficients = state.model.vector[state.free] * self.scale

    @cached_property
    def columns(self) -> Array:
        """Return derivatives ``(3 K, F)`` of positions [m] by the free coordinates, each over its ``scale``, at random poses within the limits."""
        return self._columns(poses_within(joint_limits(self._state), self._state, N_POSES))

    @cached_property
    def columns_in_ranges(self) -> Array:
        """Return the same at random poses within the ranges of the joints that were measured."""
        return self._columns(poses_within(measured_ranges(self._state), self._state, N_POSES))

    @cached_property
    def columns_measured(self) -> Array:
        """Return the same at measured poses."""
        return self._columns(poses_measured(self._state, N_POSES))

    def _columns(self, poses: Poses) -> Array:
        return displacement_columns(self._state, poses)[:, self._state.free] / self.scale

    def fitted(self, free: Array) -> tuple[Array, Array]:
        """Return the step ``(F,)`` to the optimum with the coordinates ``free`` ``(F,)`` bool, and the steps ``(N, F)`` when each pose is left out.

        The other coordinates become zero. Steps are in units of ``scale``.
        """
        N, m = self._poses
        J = self._J[:, free]
        step = np.where(free, 0.0, -self.coefficients)
        inverse = np.linalg.pinv(self._gram[np.ix_(free, free)], rcond=1e-12, hermitian=True)
        step[free] = -inverse @ (self._projection[free] + self._gram[np.ix_(free, ~free)] @ step[~free])
        rest = (self._residual + self._J @ step)[: N * m].reshape(N, m)
        left_out = np.zeros((N, len(free)))
        left_out[:, free] = steps_left_out(J[: N * m].reshape(N, m, -1), rest, inverse)
        return step, left_out


def moves(state: FittedState, whitening: Array | None) -> Moves:
    """Return the moves of a fit of a state's poses.

    Args:
        state: Near the optimum.
        whitening: As for ``Linearised``.
    """
    linear = Linearised(state if whitening is None else as_whitened(state), whitening)
    step, left_out = linear.fitted(np.ones(len(linear.scale), dtype=bool))
    return Moves(linear.columns @ step, left_out @ linear.columns.T)


def steps_left_out(rows: Array, rest: Array, inverse: Array) -> Array:
    """Return the steps of an optimum ``(N, F)`` when each pose is left out.

    Args:
        rows: ``(N, m, F)``, derivatives of each pose's rows.
        rest: ``(N, m)``, residuals at the optimum.
        inverse: ``(F, F)``, of the normal equations of all poses.
    """
    response = rows @ inverse
    taken, axes = np.linalg.eigh(response @ np.swapaxes(rows, 1, 2))
    along = np.einsum("nij,ni->nj", axes, rest) / np.maximum(1.0 - taken, _LEAST_LEFT)
    return np.einsum("nmf,nm->nf", response, np.einsum("nij,nj->ni", axes, along))


def variance_of(steps: Array, columns: Array) -> float:
    """Return the squared standard error of a predicted position [m^2], mean over the random poses.

    Args:
        steps: ``(N, F)``, as ``steps_left_out`` gives them.
        columns: ``(3 K, F)``, derivatives of the predicted positions [m].
    """
    about = steps - steps.mean(axis=0)
    N = len(steps)
    return float((N - 1) / N * np.sum((columns @ (about.T @ about)) * columns) / (len(columns) / 3))


def _standard_error(left_out: Array) -> float:
    N = len(left_out)
    about = left_out - left_out.mean(axis=0)
    return float(np.sqrt((N - 1) / N * np.sum(about * about) / (about.shape[1] / 3)))


def _length(move: Array) -> float:
    return float(np.sqrt(np.sum(move * move) / (len(move) / 3)))
