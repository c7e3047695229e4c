"""Define the candidate explanations of the published curves: their effects, the grids of their magnitudes, and their predictions.

A magnitude has a grid, on whose nodes its prior is uniform; the grid is logarithmic, but for the number of iterations. A pair of effects has two
magnitudes. Predictions are computed once for all nodes, and all later steps look them up.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
import pandas as pd

from scalar.geometry.se3 import Array
from scalar.units import MM, MRAD
from study.common.methods import CONVERGED
from study.common.statistics import QUANTITIES
from study.published_curves.curves import Curves, Setting
from study.published_curves.ensemble import Ensemble, Sizes


@dataclass(frozen=True)
class Magnitude:
    """The magnitude of an effect, which is fitted: a field of ``Sizes`` with a grid of values.

    Attributes:
        name: Name of the field.
        unit: Unit of the magnitude in tables, part of the names of columns.
        factor: Factor from SI units to that unit.
        values: The grid, ascending [SI units].
    """

    name: str
    unit: str
    factor: float
    values: tuple[float, ...]


def _doubling(low: float, count: int) -> tuple[float, ...]:
    """Return ``count`` values that double from ``low`` on."""
    return tuple(low * 2.0**k for k in range(count))


STEPS = _doubling(1e-4, 7)
"""Steps to which ranges are rounded [m]. There are few, because for each step all points are rounded anew."""

MAGNITUDES = {
    "noise": Magnitude("noise", "factor", 1.0, _doubling(0.5, 6)),
    "shared": Magnitude("shared", "share", 1.0, _doubling(0.03125, 7)),
    "scan": Magnitude("scan", "mm", 1 / MM, _doubling(5e-6, 8)),
    "joint": Magnitude("joint", "mrad", 1 / MRAD, _doubling(5e-6, 8)),
    "step": Magnitude("step", "mm", 1 / MM, STEPS),
    "tolerance": Magnitude("tolerance", "relative", 1.0, tuple(0.9 * 4.0**k for k in range(-10, 1))),
    "iterations": Magnitude("iterations", "count", 1.0, tuple(float(k) for k in range(2, 16))),
}
"""``{name: magnitude}``. Most grids double from node to node, since the logarithm of an error is nearly linear between two such nodes."""


@dataclass(frozen=True)
class Candidate:
    """A candidate explanation of the curves: effects that act in the workcell, or a method of calibration.

    Attributes:
        name: Name in tables.
        label: Name in figures.
        magnitudes: Names of the magnitudes that are fitted; none, one or two.
        method: Name of the method with which the sweeps' fits were made, if the candidate is a method; else "".
    """

    name: str
    label: str
    magnitudes: tuple[str, ...] = ()
    method: str = ""

    @property
    def axes(self) -> tuple[Magnitude, ...]:
        """Return the magnitudes, in the order of their names."""
        return tuple(MAGNITUDES[name] for name in self.magnitudes)

    def nodes(self) -> Array:
        """Return the n nodes of the grid of k magnitudes ``(n, k)`` [SI units]; the last magnitude varies fastest."""
        return np.array(list(product(*(axis.values for axis in self.axes))), dtype=float)

    def sizes(self, node: Sequence[float]) -> Sizes:
        """Return the sizes of the effects at a node."""
        values: dict[str, Any] = dict(zip(self.magnitudes, map(float, node), strict=True))
        if "iterations" in values:
            values["iterations"] = int(values["iterations"])
        return Sizes(**values)


STATED = "stated"
"""Name of the candidate in which there is nothing but the stated noise."""
CANDIDATES = (
    Candidate(STATED, "stated noise alone"),
    Candidate("noise", "more noise a point", ("noise",)),
    Candidate("shared", "noise partly common to a scan", ("shared",)),
    Candidate("scan", "error common to a scan", ("scan",)),
    Candidate("joint", "joints repeat imperfectly", ("joint",)),
    Candidate("step", "ranges rounded", ("step",)),
    Candidate("tolerance", "stopped by a loose tolerance", ("tolerance",)),
    Candidate("iterations", "stopped after some iterations", ("iterations",)),
    Candidate("abs", "root read as √|·|", method="baseline-abs"),
    Candidate("abs-2018", "root read as √|·|, lmfit of 2018", method="baseline-abs-2018"),
    Candidate("clip", "root read as √max(0, ·)", method="baseline-clip"),
    Candidate("noise+scan", "more noise, error common to a scan", ("noise", "scan")),
    Candidate("noise+joint", "more noise, joints' repeatability", ("noise", "joint")),
    Candidate("noise+step", "more noise, ranges rounded", ("noise", "step")),
    Candidate("noise+shared", "more noise, partly common to a scan", ("noise", "shared")),
    Candidate("shared+iterations", "noise partly common, stopped early", ("shared", "iterations")),
    Candidate("shared+scan", "noise partly common, error common to a scan", ("shared", "scan")),
    Candidate("shared+joint", "noise partly common, joints' repeatability", ("shared", "joint")),
    Candidate("shared+step", "noise partly common, ranges rounded", ("shared", "step")),
    Candidate("scan+joint", "error common to a scan, joints' repeatability", ("scan", "joint")),
)


@dataclass(frozen=True, eq=False)
class Prediction:
    """What a candidate predicts for R published runs at the n nodes of its grid: log errors ~ N(mean, covariance).

    Attributes:
        candidate: The candidate.
        nodes: ``(n, k)``, its k magnitudes at each node [SI units].
        mean: ``(n, R, 4)``, means of the log errors.
        covariance: ``(n, R, 4, 4)``, their covariances.
        shares: ``(n, R, 3)``, shares of the squared position error that errors of points, of scans and of joints cause.
    """

    candidate: Candidate
    nodes: Array
    mean: Array
    covariance: Array
    shares: Array


SAMPLING_VARIANCE = 4e-4
"""Added to the variances of log errors (2 %): they are computed over some hundred evaluation poses, and the original paper used others."""


def predict(
    ensemble: Ensemble, candidates: Sequence[Candidate], settings: Sequence[Setting]
) -> dict[str, Prediction]:
    """Return ``{name: prediction}`` for the candidates that are effects.

    Args:
        ensemble: Simulated workcells.
        candidates: The candidates; those that are methods are left out.
        settings: The settings of the R runs.
    """
    chosen = [c for c in candidates if not c.method]
    nodes = {c.name: c.nodes() for c in chosen}
    mean = {c.name: np.zeros((len(nodes[c.name]), len(settings), 4)) for c in chosen}
    cov = {c.name: np.zeros((len(nodes[c.name]), len(settings), 4, 4)) for c in chosen}
    shares = {c.name: np.zeros((len(nodes[c.name]), len(settings), 3)) for c in chosen}
    first_with: dict[tuple[tuple[int, int], float], int] = {}
    for i in sorted(range(len(settings)), key=lambda i: (settings[i].design, settings[i].sigma)):
        setting = settings[i]
        first = first_with.setdefault((setting.design, setting.sigma), i)
        ensemble.forget_others(setting)
        for candidate in chosen:
            tables = mean[candidate.name], cov[candidate.name], shares[candidate.name]
            if first != i and not {"tolerance", "iterations"} & set(candidate.magnitudes):
                # Runs that differ only in the initial guesses of the planes differ only in the path of the solver.
                for table in tables:
                    table[:, i] = table[:, first]
                continue
            for k, node in enumerate(nodes[candidate.name]):
                sizes = candidate.sizes(node)
                tables[0][k, i], tables[1][k, i] = moments(ensemble.log_errors(setting, sizes))
                tables[2][k, i] = ensemble.shares(setting, sizes)
    return {c.name: Prediction(c, nodes[c.name], mean[c.name], cov[c.name], shares[c.name]) for c in chosen}


def moments(samples: Array) -> tuple[Array, Array]:
    """Return mean ``(4,)`` and covariance ``(4, 4)`` of samples ``(S, 4)``, with ``SAMPLING_VARIANCE`` added."""
    return samples.mean(axis=0), np.cov(samples.T) + SAMPLING_VARIANCE * np.eye(samples.shape[1])


def predict_from_fits(
    candidate: Candidate, curves: Curves, sweeps: Mapping[str, pd.DataFrame], walls: str
) -> Prediction | None:
    """Return the prediction from the fits of the sweeps; None if they lack a published run, or have fewer than ``MIN_FITS`` fits of it.

    Args:
        candidate: A candidate that is a method.
        curves: The published runs.
        sweeps: ``{sweep: its errors.csv}``.
        walls: The kind of walls whose fits are used.
    """
    mean, cov = [], []
    for row in curves.table.to_dict("records"):
        table: Any = sweeps.get(str(row["sweep"]))
        if table is None:
            return None
        here = table[
            (table["walls"] == walls)
            & (table["method"] == candidate.method)
            & (table["alignment"] == "raw")
            & (table["status"] == CONVERGED)
            & (abs(table["value"] - row["value"]) <= 1e-6 * abs(row["value"]))
        ]
        samples = np.log(here[list(QUANTITIES)].to_numpy(dtype=float))
        if len(samples) < MIN_FITS:
            return None
        m, c = moments(samples)
        mean.append(m)
        cov.append(c)
    shares = np.tile([1.0, 0.0, 0.0], (1, len(mean), 1))
    return Prediction(candidate, np.zeros((1, 0)), np.array([mean]), np.array([cov]), shares)


MIN_FITS = 8
"""Fewest converged fits from which the covariance of the four errors is computed."""
