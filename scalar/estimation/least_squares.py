"""One Levenberg-Marquardt run over the free coordinates of a model, with the analytic Jacobian, and the covariance at its optimum.

``minimise |r(x)|^2`` over the free coordinates x; r is whitened, so ``(J' J)^-1`` at the optimum is their covariance. The steps are those of
MINPACK (Moré, 1978), taken by the compiled library where it applies and else by SciPy. ``scalar.estimation.lmfit_fit`` is the same fit through
lmfit, with lmfit's report.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg.lapack import dtrtri  # pyright: ignore[reportAttributeAccessIssue]  # made by f2py

from scalar.estimation.minpack import levenberg_marquardt
from scalar.estimation.model import Model
from scalar.estimation.residuals import Residuals
from scalar.geometry.se3 import Array

TOLERANCE = 1e-10  # relative, on cost and coordinates; a smaller tolerance would only add steps that are as large as rounding errors
MAX_EVALUATIONS = 200
FIRST_STEP = 0.1  # of the coordinates' own size: with MINPACK's default, 100, angles along a weak direction jump by whole turns
RANK_TOLERANCE = 1e-10  # of the largest singular value of the column-scaled Jacobian
WELL_CONDITIONED = 1e6  # condition number of the column-scaled Jacobian below which its rank is beyond doubt: far from 1 / RANK_TOLERANCE
NEGLIGIBLE_STEP = 1e-3  # standard deviations: a remaining Gauss-Newton step below this does not matter


@dataclass(frozen=True, eq=False)
class Fit:
    """The result of a run.

    Attributes:
        model: At the optimum.
        free: ``(P,)`` bool, which coordinates were free.
        evaluations: Calls of the residual.
        message: How the solver says that it ended.
        residual: Returns the residual ``(R,)`` at the optimum.
        uncertainty: Returns there what ``covariance_and_step`` returns.
    """

    model: Model
    free: Array
    evaluations: int
    message: str
    residual: Callable[[], Array]
    uncertainty: Callable[[], tuple[Array, float]]

    @cached_property
    def chi_squared(self) -> float:
        """Return the sum of squared whitened residuals; computed when it is first asked for, since many fits are only starts of others."""
        residual = self.residual()
        return float(residual @ residual)

    @cached_property
    def _covariance_and_step(self) -> tuple[Array, float]:
        return self.uncertainty()

    @property
    def covariance(self) -> Array:
        """Return the covariance ``(F, F)`` of the free coordinates, for residuals of unit variance; computed when it is first asked for."""
        return self._covariance_and_step[0]

    @property
    def converged(self) -> bool:
        """Return whether the remaining Gauss-Newton step is negligible beside the standard errors."""
        step = self._covariance_and_step[1]
        return bool(np.isfinite(step) and step < NEGLIGIBLE_STEP)


class Objective:
    """Residual and Jacobian as functions of the free coordinates. The latest ones are kept, because solvers ask for them again.

    Attributes:
        free: ``(F,)``, indices of the free coordinates.
        start: ``(P,)``, all coordinates where the fit starts.
        evaluations: Calls of the residual so far.
    """

    def __init__(self, residuals: Residuals, model: Model, free: Array) -> None:
        self.residuals, self.model = residuals, model
        self.free = np.flatnonzero(free)
        self.start = model.vector
        self.evaluations = 0
        self._latest, self._x_latest = model, self.start[self.free]
        self._residual: tuple[Model, Array] | None = None
        self._linearised: tuple[Model, Array, Array] | None = None

    def at(self, x: Array) -> Model:
        """Return the model at free coordinates; the same object as last time where they have not changed."""
        if not np.array_equal(x, self._x_latest):
            vector = self.start.copy()
            vector[self.free] = x
            self._latest, self._x_latest = self.model.with_vector(vector), np.array(x)
        return self._latest

    def residual(self, x: Array) -> Array:
        """Return the residual ``(R,)`` at free coordinates ``(F,)``."""
        self.evaluations += 1
        model = self.at(x)
        if self._residual is None or self._residual[0] is not model:
            self._residual = model, self.residuals.residual(model)
        return self._residual[1]

    def jacobian(self, x: Array) -> Array:
        """Return the Jacobian ``(R, F)`` at free coordinates ``(F,)``."""
        return self.linearised(self.at(x))[1]

    def linearised(self, model: Model) -> tuple[Array, Array]:
        """Return the residual ``(R,)`` and its Jacobian ``(R, F)`` by the free coordinates; SciPy asks for it twice at the start."""
        if self._linearised is None or self._linearised[0] is not model:
            residual, jacobian = self.residuals.linearise(model)
            self._linearised = model, residual, jacobian[:, self.free]
        return self._linearised[1], self._linearised[2]

    def ended(self, x: Array, free: Array, message: str) -> Fit:
        """Return the result of a solver that ended at the free coordinates ``x`` ``(F,)``.

        Args:
            x: ``(F,)``.
            free: ``(P,)`` bool, which coordinates were free.
            message: How the solver says that it ended.
        """
        optimum = self.at(x)
        return Fit(
            model=optimum,
            free=free,
            evaluations=self.evaluations,
            message=message,
            residual=lambda: self.residuals.residual(optimum),
            uncertainty=lambda: self._uncertainty(optimum, free),
        )

    def _uncertainty(self, optimum: Model, free: Array) -> tuple[Array, float]:
        """Return what ``covariance_and_step`` returns at an optimum.

        Where the compiled library makes the normal equations, they give it, in a third of the time, unless they have too few digits.
        """
        if self.residuals.plane_problem(optimum) is not None and not optimum.priors:
            found = self.residuals.normal_equations(optimum, free).covariance_and_step()
            if found is not None:
                return found
        residual, J = self.linearised(optimum)
        return covariance_and_step(J, residual)


def fit(residuals: Residuals, model: Model, free: Array, *, tolerance: float = TOLERANCE) -> Fit:
    """Return the least-squares optimum over the free coordinates of a model.

    Args:
        residuals: Of the dataset.
        model: Initial values; fixed coordinates keep them.
        free: ``(P,)`` bool.
        tolerance: Relative, on cost and coordinates.
    """
    objective = Objective(residuals, model, free)
    x = objective.start[objective.free]
    if not len(x):
        return objective.ended(x, free, "nothing is free")
    compiled = _compiled(objective, tolerance)
    if compiled is not None:
        return objective.ended(compiled, free, "compiled")
    with np.errstate(all="ignore"):  # a step too far may overflow; the solver takes it back
        x, message, _ = levenberg_marquardt(
            objective.residual,
            objective.jacobian,
            x,
            ftol=tolerance,
            xtol=tolerance,
            max_evaluations=MAX_EVALUATIONS,
            factor=FIRST_STEP,
        )
        return objective.ended(x, free, message)


def _compiled(objective: Objective, tolerance: float) -> Array | None:
    """Return the optimum ``(F,)`` by the compiled library, which takes MINPACK's steps; None if it does not apply or gave up numerically."""
    residuals, model = objective.residuals, objective.model
    problem = None if residuals.known is not None else residuals.plane_problem(model)
    if problem is None:
        return None
    P = len(objective.start)
    mean, weight = np.zeros(P), np.zeros(P)
    if model.priors:
        _, index, slope = model.prior_rows()
        mean[index], weight[index] = [prior.mean for prior in model.priors], slope
        if np.count_nonzero(weight) > np.count_nonzero(weight[objective.free]):
            return None
    found = problem.fit(
        objective.start,
        objective.free,
        mean[objective.free],
        weight[objective.free],
        tolerance=tolerance,
        first_step=FIRST_STEP,
        max_evaluations=MAX_EVALUATIONS,
    )
    if found is None:
        return None
    objective.evaluations = found.evaluations
    return found.vector[objective.free]


@dataclass(frozen=True, eq=False)
class Decomposed:
    """A Jacobian with unit columns, ``J / scale = Q R``, and the residual along its columns.

    Where R is clearly of full rank, its inverse gives the covariance; else its singular values tell which directions are observed.

    Attributes:
        scale: ``(F,)``, lengths of the columns; 1 where a column is zero.
        R: ``(min(F, rows), F)``, upper triangular; it has the singular values of ``J / scale``.
        along: ``(min(F, rows),)``, the component of the residual along each column of Q.
        rms: Root mean square of the residual.
    """

    scale: Array
    R: Array
    along: Array
    rms: float

    @classmethod
    def of(cls, J: Array, residual: Array) -> Decomposed | None:
        """Return the decomposition of a Jacobian ``(R, F)``, or None where it or the residual ``(R,)`` is not finite."""
        scale = np.sqrt(np.einsum("rf,rf->f", J, J))
        scale[scale == 0] = 1.0
        sum_of_squares = float(residual @ residual)
        if not (np.all(np.isfinite(scale)) and np.isfinite(sum_of_squares)):
            return None
        factor = np.asarray(np.linalg.qr(np.column_stack([J / scale, residual]), mode="r"))[: len(scale)]
        rms = float(np.sqrt(sum_of_squares / max(len(residual), 1)))
        return cls(scale, factor[:, :-1], factor[:, -1], rms)

    @cached_property
    def _inverse(self) -> Array | None:
        """Return the inverse of R ``(F, F)``; None if R is not square, or if its condition number may exceed ``WELL_CONDITIONED``."""
        rows, F = self.R.shape
        if rows < F or F == 0:
            return None
        inverse, failed = dtrtri(self.R)
        condition = np.sqrt(F) * np.linalg.norm(inverse)  # an upper bound: the columns of R have unit length
        return None if failed or not condition < WELL_CONDITIONED else inverse

    @cached_property
    def _svd(self) -> tuple[Array, Array, Array]:
        """Return U ``(F, F)``, the singular values ``(F,)``, the largest first, and V transposed ``(F, F)``, of R."""
        return np.linalg.svd(self.R, full_matrices=False)

    @property
    def _observed(self) -> Array:
        s = self._svd[1]
        return s > RANK_TOLERANCE * s[0] if len(s) else s > 0

    @property
    def full_rank(self) -> bool:
        """Return whether the data distinguish all columns."""
        if self._inverse is not None:
            return True
        return len(self.R) == len(self.scale) and bool(np.all(self._observed))

    @property
    def weakest(self) -> Array:
        """Return the direction of unit length ``(F,)`` of the scaled columns that the data determine least."""
        return self._svd[2][-1]

    @property
    def covariance(self) -> Array:
        """Return the pseudo-inverse of ``J' J``, ``(F, F)``: directions that are not observed count as exactly known."""
        inverse = self._inverse
        if inverse is None:
            _, s, Vt = self._svd
            inverse = Vt[self._observed].T / s[self._observed]
        inverse = inverse / self.scale[:, None]
        return inverse @ inverse.T

    @property
    def step(self) -> float:
        """Return the length of the remaining Gauss-Newton step in standard deviations, as ``covariance_and_step`` counts it."""
        along = self.along if self._inverse is not None else (self._svd[0].T @ self.along)[self._observed]
        return float(np.linalg.norm(along)) / max(1.0, self.rms)


def covariance_and_step(J: Array, residual: Array) -> tuple[Array, float]:
    """Return ``(J' J)^-1`` and the length of the remaining Gauss-Newton step in standard deviations.

    The step's length is ``|P_J r|``, with P_J the projection on the columns. It is divided by the residual's root mean square if that exceeds
    one: a coarse model with a misfit of many standard deviations need not be optimised to more digits than it can have. If J or the residual
    is not finite, the covariance is NaN and the step infinite.
    """
    found = Decomposed.of(J, residual)
    if found is None:
        return np.full((J.shape[1], J.shape[1]), np.nan), np.inf
    return found.covariance, found.step
