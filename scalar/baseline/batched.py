"""The baseline computed faster, for sweeps: the same finite differences, all columns at once.

``calibrate_baseline`` leaves the derivatives to lmfit, which computes the residual of all scans once for each
parameter. Here the same forward differences, with the same step, are computed together: a plane is carried forward
through the joints as a row ``(n, -d) T``, the scanner's axes backward, so that the column of a parameter
needs its own link alone. MINPACK then takes the steps that it takes for lmfit, and every column counts as an
evaluation, as it does there. No covariance is computed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from scalar.baseline.fit import DEFAULTS, first_guess
from scalar.baseline.parameterisation import DH_KINDS, READINGS, SENSOR, Parameterisation
from scalar.data.dataset import Dataset
from scalar.estimation.minpack import levenberg_marquardt
from scalar.estimation.model import Model
from scalar.geometry.robot import link_transforms
from scalar.geometry.se3 import Array, exp_so3, transform
from scalar.kernels import LIBRARY
from scalar.kernels.published_problem import PublishedProblem
from scalar.sensors import Scans, as_scans, measure

NAN_POLICIES = ("raise", "propagate")
"""What happens if a residual or a derivative is not a number. ``raise``, lmfit's default, ends the fit; ``propagate`` passes it to MINPACK,
which rejects a trial with such a residual, and stops at such a derivative."""

_CONTACT = [3, 0, 2]  # columns of a frame that a plane's row is multiplied with: the origin, the axes X and Z


@dataclass(frozen=True, eq=False)
class BaselineEnd:
    """How a fit of the baseline ended.

    Attributes:
        model: The model in reporting coordinates: at the optimum; at the last trial that has residuals if capped; at the start if raised.
        status: ``converged``, ``capped``, ``raised`` or ``stopped``, as ``calibrate_baseline`` has them.
        evaluations: Number of evaluations of the residual; each column of the derivatives counts as one.
        rms: Root mean square distance of the points from their planes [m].
    """

    model: Model
    status: str
    evaluations: int
    rms: float


class _Capped(Exception):
    pass


class _NotANumber(Exception):
    pass


def fit_baseline(
    dataset: Dataset,
    reading: str,
    fixed: Sequence[str],
    max_nfev: int,
    defaults: str = "now",
    nan_policy: str = "raise",
) -> BaselineEnd:
    """Return where the baseline ends on a dataset of line scans, starting from its own initial estimate.

    Args:
        dataset: What was measured.
        reading: How the constraints' root is read, a key of ``scalar.baseline.parameterisation.READINGS``.
        fixed: Names of parameters that stay at their nominal values.
        max_nfev: The fit is capped after so many evaluations of the residual.
        defaults: Version of lmfit's defaults, a key of ``scalar.baseline.fit.DEFAULTS``.
        nan_policy: That of lmfit, one of ``NAN_POLICIES``.

    Raises:
        Undetermined: The data determine no first guess.
        ValueError: The reading or the policy is unknown, or the dataset holds no line scans.
    """
    if nan_policy not in NAN_POLICIES:
        raise ValueError(f"nan_policy must be one of {', '.join(NAN_POLICIES)}")
    measurement = as_scans(measure(dataset))
    how = Parameterisation(dataset.robot, measurement.initial_target(dataset))
    start = how.values(first_guess(dataset, measurement, how.planes)[0])
    lmfit = DEFAULTS[defaults]
    step = float(np.sqrt(lmfit["epsfcn"]))
    distances = Distances(how, dataset.q, measurement, start, fixed, reading, max_nfev, step, nan_policy)
    x, status = start[distances.free], "stopped"
    with np.errstate(all="ignore"):
        try:
            x, _, info = levenberg_marquardt(
                distances.residual,
                distances.jacobian,
                x,
                ftol=lmfit["ftol"],
                xtol=lmfit["xtol"],
                gtol=lmfit["gtol"],
                max_evaluations=max_nfev,
            )
            status = "converged" if info in (1, 2, 3, 4) else "stopped"
        except _Capped:
            x, status = distances.latest, "capped"
        except _NotANumber:
            status = "raised"
        values = distances.values(x) if status != "raised" else start
    scale = np.linalg.norm(how.unpack(values)[2], axis=1)[distances.index]
    squares = np.sum(distances.rows(values).reshape(len(scale), -1) ** 2, axis=1) / scale**2
    rms = float(np.sqrt(squares.sum() / len(dataset.points)))
    return BaselineEnd(how.model(values), status, distances.evaluations, rms)


class Distances:
    """Compressed distances ``n . p - d`` [m] and their forward differences, as functions of the varying parameters ``(V,)``."""

    def __init__(
        self,
        how: Parameterisation,
        q: Array,
        measurement: Scans,
        start: Array,
        fixed: Sequence[str],
        reading: str,
        max_nfev: int,
        step: float,
        nan_policy: str = "raise",
    ) -> None:
        if reading not in READINGS:
            raise ValueError(f"reading is one of {', '.join(READINGS)}")
        self.how, self.q, self.start, self.reading, self.max_nfev, self.step = (
            how,
            q,
            start,
            reading,
            max_nfev,
            step,
        )
        self.propagates = nan_policy == "propagate"
        self.index = measurement.target_index.astype(np.intp)
        self.R = measurement.R_metric
        names = how.names
        stems = ("r", *(f"normal_{name}" for name in how.planes.names))
        self.thirds = np.array([names.index(f"{stem}_z") for stem in stems])
        not_free = {*fixed, *(names[i] for i in self.thirds)}
        self.free = np.array([i for i, name in enumerate(names) if name not in not_free])
        self.evaluations = 0
        self.latest = np.full(len(self.free), np.nan)
        self._problem: PublishedProblem | None = None
        robot = how.nominal
        if LIBRARY is not None and not robot.prismatic:
            self._problem = PublishedProblem(
                q, self.index, self.R, robot.geometry[-1], robot.T_base_0, robot.T_n_flange,
                len(how.planes.names), reading,
            )  # fmt: skip
        self._found: Array | None = None
        self._derived: tuple[Array, Array] | None = None

    def values(self, x: Array) -> Array:
        """Return all parameters ``(P,)``, the third component of each unit vector as the reading has it."""
        values = self.start.copy()
        values[self.free] = x
        return self.constrained(values)

    def constrained(self, values: Array) -> Array:
        """Return parameters ``(..., P)`` with third components ``sqrt(1 - n_x^2 - n_y^2)``, by the reading chosen."""
        values = values.copy()
        rest = 1.0 - values[..., self.thirds - 2] ** 2 - values[..., self.thirds - 1] ** 2
        if self.reading != "raise":
            rest = np.abs(rest) if self.reading == "abs" else np.maximum(rest, 0.0)
        values[..., self.thirds] = np.sqrt(rest)
        return values

    def residual(self, x: Array) -> Array:
        """Return the compressed distances ``(3 N,)`` [m], counted as one evaluation."""
        if self._found is not None and np.array_equal(self.latest, x):
            return self._found  # SciPy asks three times at the start
        self._count(1)
        found = self.rows(self.values(x))
        if np.isnan(found).any():
            if self.propagates:
                return found
            raise _NotANumber
        self.latest, self._found = np.array(x), found
        return found

    def rows(self, values: Array) -> Array:
        """Return the compressed distances ``(3 N,)`` [m] at all parameters ``(P,)``."""
        if self._problem is not None:
            return self._problem.rows(values)
        robot, T_flange_sensor, normals, distances = self.how.unpack(values)
        T = robot.flange(self.q) @ T_flange_sensor
        plane = np.column_stack([normals, -distances])[self.index]
        return (self.R @ (plane[:, None, :] @ T[:, :, _CONTACT]).swapaxes(1, 2)).ravel()

    def jacobian(self, x: Array) -> Array:
        """Return MINPACK's forward differences ``(3 N, V)``, a column counted as an evaluation."""
        if self._derived is not None and np.array_equal(self._derived[0], x):
            return self._derived[1]
        self._count(len(self.free))
        values = self.values(x)
        steps = self.step * np.abs(values)
        steps[steps == 0] = self.step
        J = self._changes(values, steps)[:, self.free] / steps[self.free]
        if np.isnan(J).any() and not self.propagates:
            raise _NotANumber
        self._derived = np.array(x), J
        return J

    def _changes(self, values: Array, steps: Array) -> Array:
        """Return how the rows change when each parameter is stepped, ``(3 N, P)``."""
        if self._problem is not None:
            return self._problem.changes(values, steps)
        return (self.R @ self._columns(values, steps).transpose(1, 2, 0)).reshape(-1, len(values))

    def _columns(self, values: Array, steps: Array) -> Array:
        """Return how the contacts ``(n.o - d, n.X, n.Z)`` change when each parameter is stepped, ``(P, N, 3)``."""
        how, N = self.how, len(self.q)
        n, K = how.nominal.n_joints, len(how.planes.names)
        n_geometry, n_sensor = len(DH_KINDS) * n, len(SENSOR)
        robot, T_flange_sensor, normals, distances = how.unpack(values)
        found = np.zeros((len(values), N, 3))
        # Backward: the scanner's axes in the frame after each link.
        links = link_transforms(robot.geometry, self.q)
        after = np.empty((N, n, 4, 3))
        after[:, -1] = (robot.T_n_flange @ T_flange_sensor)[:, _CONTACT]
        for i in range(n - 1, 0, -1):
            after[:, i - 1] = links[:, i] @ after[:, i]
        contact = robot.T_base_0 @ links[:, 0] @ after[:, 0]
        # Forward: the plane's row before each link.
        before = np.empty((N, n + 1, 1, 4))
        before[:, 0] = np.column_stack([normals, -distances])[self.index][:, None] @ robot.T_base_0
        for i in range(n):
            before[:, i + 1] = before[:, i] @ links[:, i]
        for k in range(len(DH_KINDS)):
            geometry = robot.geometry.copy()
            geometry[k] += steps[k * n : (k + 1) * n]
            change = before[:, :n] @ (link_transforms(geometry, self.q) - links) @ after
            found[k * n : (k + 1) * n] = change[:, :, 0].swapaxes(0, 1)
        of_sensor = n_geometry + np.arange(n_sensor)
        stepped = np.repeat(values[None], len(of_sensor), axis=0)
        stepped[np.arange(len(of_sensor)), of_sensor] += steps[of_sensor]
        stepped = self.constrained(stepped)[:, of_sensor]
        axes = stepped[:, :3] / np.linalg.norm(stepped[:, :3], axis=1)[:, None]
        moved = transform(exp_so3(axes * stepped[:, 3:4]), stepped[:, 4:]) - T_flange_sensor
        found[of_sensor] = ((before[:, n] @ robot.T_n_flange) @ moved[:, None][..., _CONTACT])[:, :, 0]
        for k in range(K):
            of_plane = n_geometry + n_sensor + 4 * k + np.arange(4)
            stepped = np.repeat(values[None], 4, axis=0)
            stepped[np.arange(4), of_plane] += steps[of_plane]
            change = (self.constrained(stepped) - values)[:, of_plane] * [1.0, 1.0, 1.0, -1.0]
            on = self.index == k
            found[of_plane[:, None], np.flatnonzero(on)] = np.einsum("ck,nkj->cnj", change, contact[on])
        return found

    def _count(self, evaluations: int) -> None:
        if self.evaluations + evaluations > self.max_nfev:
            self.evaluations = self.max_nfev
            raise _Capped
        self.evaluations += evaluations
