"""The variance of predictions at poses that were not measured, by leaving out one pose at a time.

It is used to compare weights of the poses, and models with different effects. The delete-one-pose jackknife (Efron and Stein, Annals of Statistics 9,
1981; CR3 of Bell and McCaffrey, Survey Methodology 28, 2002) is valid for any covariance within a pose, even if the weights of a fit are wrong. A fit
with the weights of a variance component that does not exist loses efficiency but is not biased; its own standard errors do not show this loss, but
those of the jackknife do. Repetitions of a pose share what the model lacks there, and are left out together.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from scalar.data.poses import Poses
from scalar.diagnosis.fit.fitted_state import FittedState, whitened
from scalar.diagnosis.fit.predicted_displacements import (
    displacement_columns,
    joint_limits,
    measured_ranges,
    poses_measured,
    poses_within,
)
from scalar.diagnosis.held_out.repetitions import first_of_repetitions_of, poses_by_repetitions
from scalar.diagnosis.selection.harmonic_spectrum import priors_for_whitened_rows
from scalar.geometry.se3 import Array

N_POSES = 200  # random poses at which predictions are compared
_LEAST_LEFT = 1e-3  # lower bound of one minus a leverage; it limits the residual of a pose that alone determines a direction


@dataclass(frozen=True, eq=False)
class PredictionChanges:
    """By how much predicted positions at K random poses change, the best rigid motion removed.

    Attributes:
        to_optimum: ``(3 K,)`` [m], from the state to the optimum under the weights of the poses.
        left_out: ``(D, 3 K)`` [m], from that optimum to the fit without each of the D distinct poses.
    """

    to_optimum: Array
    left_out: Array

    @property
    def std(self) -> float:
        """Return the standard error of a predicted position [m], root mean square over the random poses."""
        return _standard_error(self.left_out)

    def difference_from(self, other: PredictionChanges) -> tuple[float, float]:
        """Return by how much the predictions of two fits of the same poses differ [m] (root mean square), and the standard error of that [m]."""
        difference = self.to_optimum - other.to_optimum
        return _root_mean_square(difference), _standard_error(self.left_out - other.left_out)


class Linearised:
    """A state, linearised at its optimum: its fits with some of its F free coordinates, and without each of its D distinct poses.

    Attributes:
        coefficients: ``(F,)``, the free coordinates, times ``scale``.
        scale: ``(F,)``, the lengths of the Jacobian's columns.
    """

    def __init__(self, state: FittedState, whitening: Array | None):
        """Linearise.

        Args:
            state: The state near its optimum.
            whitening: ``(N, m, m)``, the weights of the poses; None for those of the noise within scans alone.
        """
        residual, J = (whitened(whitening, rows) for rows in state.linearised())
        self._poses = state.dataset.n_poses, state.residuals.measurement.rows_per_pose
        self.scale = np.linalg.norm(J, axis=0)
        self.scale[self.scale == 0] = 1.0
        self._residual, self._J = residual, J / self.scale
        self._gram, self._projection = self._J.T @ self._J, self._J.T @ residual
        # An entry of the data sheet is expected to err by its prior standard deviation. In its row, that is ``misfit_ratio``.
        self._data_sheet = self._J[len(J) - len(state.model.priors) :] * state.model.misfit_ratio
        self._repeated = poses_by_repetitions(first_of_repetitions_of(state))
        self._state = state
        self.coefficients = state.model.vector[state.free] * self.scale

    @cached_property
    def columns(self) -> Array:
        """Return derivatives ``(3 K, F)`` of positions [m] by the free coordinates times ``scale``, at K random poses within the joint limits."""
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
        """Return these derivatives at any K poses."""
        return displacement_columns(self._state, poses)[:, self._state.free] / self.scale

    def fitted(self, free: Array) -> tuple[Array, Array]:
        """Return the step ``(F,)`` to the optimum of a nested model, and the further steps ``(D, F)`` when each distinct pose is left out of its fit.

        Args:
            free: ``(F,)`` bool, the coordinates that the nested model has; the step makes all others zero. Steps are changes of ``coefficients``.
        """
        N, m = self._poses
        J = self._J[:, free]
        inverse = self._inverse(free)
        step = self._step(free, inverse)
        rest = (self._residual + self._J @ step)[: N * m].reshape(N, m)
        rows = J[: N * m].reshape(N, m, -1)
        left_out = np.zeros((sum(map(len, self._repeated)), len(free)))
        begin = 0
        for poses in self._repeated:
            n = len(poses)
            of_group, rest_of_group = rows[poses].reshape(n, -1, J.shape[1]), rest[poses].reshape(n, -1)
            left_out[begin : begin + n, free] = steps_left_out(of_group, rest_of_group, inverse)
            begin += n
        return step, left_out

    def sum_of_squares(self, free: Array) -> float:
        """Return the sum of squares of the whitened residuals of all poses at the optimum of a nested model.

        Args:
            free: ``(F,)`` bool, as for ``fitted``.
        """
        N, m = self._poses
        step = self._step(free, self._inverse(free))
        rest = (self._residual + self._J @ step)[: N * m]
        return float(rest @ rest)

    def steps_of_data_sheet(self, free: Array) -> Array:
        """Return the steps ``(K, F)`` to the optimum of a nested model if each of its K priors from the data sheet errs by a standard deviation.

        Leaving out poses does not show these errors: where the poses determine nothing, the data sheet alone decides, with or without a pose.

        Args:
            free: ``(F,)`` bool, as for ``fitted``.
        """
        steps = np.zeros((len(self._data_sheet), len(free)))
        if len(steps):
            steps[:, free] = self._data_sheet[:, free] @ self._inverse(free)
        return steps

    def _step(self, free: Array, inverse: Array) -> Array:
        """Return the step ``(F,)`` to the optimum of a nested model, whose inverse normal equations are given."""
        step = np.where(free, 0.0, -self.coefficients)
        step[free] = -inverse @ (self._projection[free] + self._gram[np.ix_(free, ~free)] @ step[~free])
        return step

    def _inverse(self, free: Array) -> Array:
        """Return the inverse normal equations of the coordinates ``free``, of as many rows and columns as there are."""
        return np.linalg.pinv(self._gram[np.ix_(free, free)], rcond=1e-12, hermitian=True)


def prediction_changes(state: FittedState, whitening: Array | None) -> PredictionChanges:
    """Return by how much predictions change with the fit of a state's poses under given weights, and when poses are left out of it.

    Args:
        state: The state near its optimum.
        whitening: Weights of the poses, as for ``Linearised``.
    """
    linear = Linearised(state if whitening is None else priors_for_whitened_rows(state), whitening)
    step, left_out = linear.fitted(np.ones(len(linear.scale), dtype=bool))
    return PredictionChanges(linear.columns @ step, left_out @ linear.columns.T)


def steps_left_out(rows: Array, rest: Array, inverse: Array) -> Array:
    """Return the steps ``(N, F)`` from an optimum to that without each pose.

    With A_i the derivatives and r_i the residual of pose i, G the normal equations of all poses, and ``H_i = A_i G^-1 A_i'`` the leverages, the step
    is ``G^-1 A_i' (I - H_i)^-1 r_i``.

    Args:
        rows: ``(N, m, F)``, the derivatives A_i; those of all repetitions, if they are left out together.
        rest: ``(N, m)``, the residuals r_i at the optimum.
        inverse: ``(F, F)``, G^-1.
    """
    response = rows @ inverse
    leverages, axes = np.linalg.eigh(response @ np.swapaxes(rows, 1, 2))
    along = np.einsum("nij,ni->nj", axes, rest) / np.maximum(1.0 - leverages, _LEAST_LEFT)
    return np.einsum("nmf,nm->nf", response, np.einsum("nij,nj->ni", axes, along))


def covariance_of(steps: Array) -> Array:
    """Return the covariance ``(F, F)`` of F coefficients by the jackknife, from the steps ``(N, F)`` without each of N poses."""
    about = steps - steps.mean(axis=0)
    N = len(steps)
    return (N - 1) / N * (about.T @ about)


def _standard_error(left_out: Array) -> float:
    """Return the jackknife's standard error of a position [m], root mean square over K poses, from ``PredictionChanges.left_out``."""
    N = len(left_out)
    about = left_out - left_out.mean(axis=0)
    return float(np.sqrt((N - 1) / N * np.sum(about * about) / (about.shape[1] / 3)))


def _root_mean_square(change: Array) -> float:
    """Return the root mean square length [m] of the changes ``(3 K,)`` of K positions."""
    return float(np.sqrt(np.sum(change * change) / (len(change) / 3)))
