"""Compute how well the published curves support a candidate explanation: likelihood, magnitudes with intervals, evidence, and held-out curves.

The log errors of published run i are modelled as ``y_i ~ N(mu_i + F_i delta, kappa^2 Sigma_i)``, with mu_i and Sigma_i the mean and covariance over
simulated seeds. Two unknowns are common to all runs. The offset delta stands for the difference between the authors' workcell and the simulated one:
the errors caused by points, scans and joints each differ by a factor for each of the four quantities (12 numbers, whose covariance is that over
simulated workcells of other shapes), and F_i weighs them by their shares in run i. The factor kappa is below 1 if runs share their poses, so that
they scatter less than workcells do, and above 1 if runs differ in what the original paper does not state.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import logsumexp

from scalar.geometry.se3 import Array
from study.published_curves.candidates import Prediction

KAPPA = np.geomspace(0.4, 2.5, 9)
"""Values of kappa, over which the likelihood is averaged with equal weights."""

REFINE = {1: 16, 2: 4}
"""``{number of magnitudes: steps between two nodes of the grid}``; predictions are smooth, so they are interpolated."""
ALL = (0, 1, 2, 3)
"""Indices of all four errors, in the order of ``QUANTITIES``."""


@dataclass(frozen=True, eq=False)
class RefinedPrediction:
    """A candidate's prediction for R runs and Q quantities, interpolated to a refined grid of n nodes.

    Attributes:
        prediction: The prediction on its own grid.
        nodes: ``(n, k)``, the k magnitudes at each node [SI units].
        mean: ``(n, R, Q)``, means mu of the log errors.
        covariance: ``(n, R, Q, Q)``, their covariances Sigma.
        precision: ``(n, R, Q, Q)``, the inverses of the covariances.
        log_det: ``(n, R)``, logarithms of the determinants of the covariances.
        shares: ``(n, R, 3)``, shares of points, scans and joints in the error, the weights F.
        quantities: The Q indices of the errors that are used.
    """

    prediction: Prediction
    nodes: Array
    mean: Array
    covariance: Array
    precision: Array
    log_det: Array
    shares: Array
    quantities: tuple[int, ...]


def refine(prediction: Prediction, quantities: tuple[int, ...] = ALL) -> RefinedPrediction:
    """Return a prediction on a finer grid, interpolated linearly in the logarithm of each magnitude.

    Args:
        prediction: The prediction on its own grid.
        quantities: Indices of those of the four errors that are used.
    """
    axes = [np.array(axis.values) for axis in prediction.candidate.axes]
    shape = [len(axis) for axis in axes]
    mean = prediction.mean.reshape(*shape, *prediction.mean.shape[1:])
    covariance = prediction.covariance.reshape(*shape, *prediction.covariance.shape[1:])
    shares = prediction.shares.reshape(*shape, *prediction.shares.shape[1:])
    finer, steps = [], REFINE.get(len(axes), 1)
    for number, axis in enumerate(axes):
        if prediction.candidate.magnitudes[number] == "iterations":
            finer.append(axis)
            continue
        place = np.linspace(0, len(axis) - 1, steps * (len(axis) - 1) + 1)
        low = np.minimum(place.astype(int), len(axis) - 2)
        part = place - low
        mean, covariance, shares = (
            _between(table, number, low, part) for table in (mean, covariance, shares)
        )
        finer.append(np.exp(np.interp(place, np.arange(len(axis)), np.log(axis))))
    grid = np.meshgrid(*finer, indexing="ij")
    count = int(np.prod([len(axis) for axis in finer]))
    nodes = np.stack([g.ravel() for g in grid], axis=1) if grid else np.zeros((1, 0))
    q = list(quantities)
    mean = mean.reshape(count, *prediction.mean.shape[1:])[..., q]
    covariance = covariance.reshape(count, *prediction.covariance.shape[1:])[..., q, :][..., q]
    return RefinedPrediction(
        prediction,
        nodes,
        mean,
        covariance,
        np.linalg.inv(covariance),
        np.linalg.slogdet(covariance)[1],
        shares.reshape(count, *prediction.shares.shape[1:]),
        quantities,
    )


def _between(table: Array, axis: int, low: Array, part: Array) -> Array:
    """Return a table interpolated along an axis, at the shares ``part`` of the way from the indices ``low`` to the next ones."""
    part = part.reshape([-1 if k == axis else 1 for k in range(table.ndim)])
    return (1 - part) * np.take(table, low, axis=axis) + part * np.take(table, low + 1, axis=axis)


def log_likelihood(refined: RefinedPrediction, y: Array, offset: Array, use: Array | None = None) -> Array:
    """Return the logarithm of the likelihood ``(n, K, S)`` over nodes, ``KAPPA`` and sets of curves, with delta integrated out.

    Args:
        refined: The prediction.
        y: ``(S, R, 4)``, log errors of S sets of curves.
        offset: ``(12, 12)``, covariance of delta.
        use: ``(R,)`` bool, the runs that are used; None: all.
    """
    q = list(refined.quantities)
    prior = _prior(offset, q)
    runs = np.flatnonzero(np.ones(y.shape[1], dtype=bool) if use is None else use)
    P, y, mean = refined.precision[:, runs], y[:, runs][..., q], refined.mean[:, runs]
    n, size = len(P), y.shape[1] * y.shape[2]
    # (y - mu)' P (y - mu) for all sets at once, by products of matrices: P : y y' - 2 (P mu) . y + mu . P mu
    P_mean = np.einsum("nrij,nrj->nri", P, mean)
    y_y = (y[..., :, None] * y[..., None, :]).reshape(len(y), -1)
    squares = P.reshape(n, -1) @ y_y.T - 2.0 * P_mean.reshape(n, -1) @ y.reshape(len(y), -1).T
    squares += np.einsum("nri,nri->n", P_mean, mean)[:, None]
    # b = sum of F' P (y - mu), A = sum of F' P F
    shares = refined.shares[:, runs]
    FP = (shares[..., :, None, None] * P[..., None, :, :]).reshape(n, len(runs), -1, len(q))
    b = FP.transpose(0, 2, 1, 3).reshape(n * FP.shape[2], -1) @ y.reshape(len(y), -1).T
    b = b.reshape(n, FP.shape[2], len(y)) - np.einsum("nrij,nrj->ni", FP, mean)[..., None]
    A = np.einsum("nrg,nrh,nrij->ngihj", shares, shares, P, optimize=True).reshape(n, FP.shape[2], -1)
    log_det = refined.log_det[:, runs].sum(axis=1)
    found = np.empty((n, len(KAPPA), len(y)))
    for k, kappa in enumerate(KAPPA):
        # Woodbury's identity: integrating delta out adds a matrix of rank 3 Q to the block diagonal covariance.
        inner = np.linalg.inv(prior) + A / kappa**2
        explained = np.einsum("nis,nis->ns", b, np.linalg.solve(inner, b)) / kappa**4
        volume = np.linalg.slogdet(inner)[1] + np.linalg.slogdet(prior)[1] + log_det
        constant = volume + size * (2 * np.log(kappa) + np.log(2 * np.pi))
        found[:, k] = -0.5 * (squares / kappa**2 - explained + constant[:, None])
    return found


def _prior(offset: Array, quantities: list[int]) -> Array:
    """Return the rows and columns of the covariance of delta that belong to some of the four quantities."""
    count = len(offset) // 4
    index = [4 * group + q for group in range(count) for q in quantities]
    return offset[np.ix_(index, index)]


def offsets_found(refined: RefinedPrediction, node: int, kappa: float, y: Array, offset: Array) -> Array:
    """Return the most probable ``F_i delta`` ``(R, Q)`` given the curves.

    Args:
        refined: The prediction.
        node: Index of the node.
        kappa: Factor on the scatter.
        y: ``(R, 4)``, log errors.
        offset: ``(12, 12)``, covariance of delta.
    """
    q = list(refined.quantities)
    P, shares = refined.precision[node] / kappa**2, refined.shares[node]
    size = shares.shape[1] * len(q)
    b = np.einsum("rg,rij,rj->gi", shares, P, y[:, q] - refined.mean[node]).ravel()
    A = np.einsum("rg,rh,rij->gihj", shares, shares, P).reshape(size, size)
    delta = np.linalg.solve(np.linalg.inv(_prior(offset, q)) + A, b)
    return shares @ delta.reshape(-1, len(q))


@dataclass(frozen=True, eq=False)
class Support:
    """The support of a candidate by one set of curves.

    Attributes:
        log_evidence: Logarithm of the likelihood averaged over the nodes and ``KAPPA``.
        log_peak: Logarithm of the largest likelihood.
        best: ``(k,)``, the magnitudes at which it is reached [SI units].
        kappa: The kappa at which it is reached.
        median: ``(k,)``, posterior medians of the magnitudes [SI units].
        intervals: ``{level: (k, 2)}``, equal-tailed posterior intervals of the magnitudes [SI units].
        at_edge: ``(k,)`` bool, whether the best magnitude is an end of its range.
        node: Index of the node at which the largest likelihood is reached.
    """

    log_evidence: float
    log_peak: float
    best: Array
    kappa: float
    median: Array
    intervals: dict[float, Array]
    at_edge: Array
    node: int


LEVELS = (0.68, 0.95)
"""Levels of the posterior intervals."""


def weigh(refined: RefinedPrediction, y: Array, offset: Array, use: Array | None = None) -> list[Support]:
    """Return the support of a candidate by each of S sets of curves.

    Args:
        refined: As in ``log_likelihood``.
        y: ``(S, R, 4)``, log errors of S sets of curves.
        offset: As in ``log_likelihood``.
        use: As in ``log_likelihood``.
    """
    found = log_likelihood(refined, y, offset, use)
    return [_support(refined, found[..., s]) for s in range(found.shape[-1])]


def _support(refined: RefinedPrediction, found: Array) -> Support:
    """Return the support by one set of curves, from its log likelihood ``(n, K)`` over nodes and ``KAPPA``."""
    total = float(logsumexp(found))
    node, k = np.unravel_index(int(np.argmax(found)), found.shape)
    weights = np.exp(logsumexp(found, axis=1) - total)
    median, edge = [], []
    intervals: dict[float, list[tuple[float, float]]] = {level: [] for level in LEVELS}
    for axis in range(refined.nodes.shape[1]):
        values, inverse = np.unique(refined.nodes[:, axis], return_inverse=True)
        share = np.bincount(inverse, weights=weights)
        cumulative = np.cumsum(share) / share.sum()
        middle = cumulative - 0.5 * share / share.sum()

        def at(p: float, middle: Array = middle, values: Array = values) -> float:
            return float(np.exp(np.interp(p, middle, np.log(values))))

        median.append(at(0.5))
        for level in LEVELS:
            intervals[level].append((at(0.5 - level / 2), at(0.5 + level / 2)))
        edge.append(refined.nodes[node, axis] in (values[0], values[-1]))
    return Support(
        log_evidence=total - float(np.log(found.size)),
        log_peak=float(found[node, k]),
        best=refined.nodes[node],
        kappa=float(KAPPA[k]),
        median=np.array(median),
        intervals={level: np.array(ends).reshape(-1, 2) for level, ends in intervals.items()},
        at_edge=np.array(edge, dtype=bool),
        node=int(node),
    )


def held_out(refined: RefinedPrediction, y: Array, offset: Array, groups: Array) -> dict[str, float]:
    """Return for every curve the logarithm of its probability density given the other curves, ``p(all) / p(others)``.

    Args:
        refined: The prediction.
        y: ``(R, 4)``, log errors.
        offset: ``(12, 12)``, covariance of delta.
        groups: ``(R,)``, the name of the curve to which each run belongs.
    """
    whole = logsumexp(log_likelihood(refined, y[None], offset))
    return {
        str(name): float(whole - logsumexp(log_likelihood(refined, y[None], offset, groups != name)))
        for name in dict.fromkeys(groups)
    }
