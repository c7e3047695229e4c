"""The support of a candidate by the curves: likelihood over its grid, magnitudes with intervals, evidence, and curves held out.

The log errors of run i are ``y_i ~ N(mu_i + F_i delta, kappa^2 Sigma_i)``, mu and Sigma from the simulated seeds. Two unknowns
are common to all runs. delta: the authors' workcell is not the simulated one, so that the errors caused by points, scans
and joints each differ by a factor for each quantity (12 numbers, whose covariance is that over simulated workcells of other shapes; F_i weighs
them by their shares in run i). kappa: runs may share their poses, so that they scatter less than workcells do, or differ
in what the paper does not state, so that they scatter more.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import logsumexp

from scalar.geometry.se3 import Array
from study.published_curves.candidates import Prediction

KAPPA = np.geomspace(0.4, 2.5, 9)
"""Values of kappa, over which the likelihood is averaged with equal weights."""

REFINE = {
    1: 16,
    2: 4,
}  # by magnitudes: steps between two nodes of a grid; predictions are smooth, and interpolated
ALL = (0, 1, 2, 3)  # quantities


@dataclass(frozen=True, eq=False)
class Fine:
    """A prediction on the refined grid, ready to weigh any curves.

    Attributes:
        prediction: It is from. nodes: ``(n, k)`` [SI]. mean: ``(n, R, Q)``. covariance: ``(n, R, Q, Q)``.
        precision: its inverse. log_det: ``(n, R)`` of the covariance. shares: ``(n, R, 3)``. quantities: Q indices.
    """

    prediction: Prediction
    nodes: Array
    mean: Array
    covariance: Array
    precision: Array
    log_det: Array
    shares: Array
    quantities: tuple[int, ...]


def refine(prediction: Prediction, quantities: tuple[int, ...] = ALL) -> Fine:
    """Return a prediction on a finer grid, interpolated linearly in the logarithm of each magnitude.

    Args:
        prediction: On its own grid. quantities: Indices of those of the four errors that are weighed.
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
    return Fine(
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
    part = part.reshape([-1 if k == axis else 1 for k in range(table.ndim)])
    return (1 - part) * np.take(table, low, axis=axis) + part * np.take(table, low + 1, axis=axis)


def log_likelihood(fine: Fine, y: Array, offset: Array, use: Array | None = None) -> Array:
    """Return the logarithm of the likelihood ``(n, K, S)`` over nodes, ``KAPPA`` and sets, delta integrated out.

    Args:
        fine: Prediction. y: ``(S, R, 4)`` log errors of S sets of curves. offset: ``(12, 12)`` covariance of delta.
        use: ``(R,)`` bool, runs.
    """
    q = list(fine.quantities)
    prior = _prior(offset, q)
    runs = np.flatnonzero(np.ones(y.shape[1], dtype=bool) if use is None else use)
    P, y, mean = fine.precision[:, runs], y[:, runs][..., q], fine.mean[:, runs]
    n, size = len(P), y.shape[1] * y.shape[2]
    # A square form in y is a product of matrices over all sets: P : y y' - 2 (P mu) . y + mu . P mu
    towards = np.einsum("nrij,nrj->nri", P, mean)
    pairs = (y[..., :, None] * y[..., None, :]).reshape(len(y), -1)
    squares = P.reshape(n, -1) @ pairs.T - 2.0 * towards.reshape(n, -1) @ y.reshape(len(y), -1).T
    squares += np.einsum("nri,nri->n", towards, mean)[:, None]
    mixed = fine.shares[:, runs]
    FP = (mixed[..., :, None, None] * P[..., None, :, :]).reshape(n, len(runs), -1, len(q))
    b = FP.transpose(0, 2, 1, 3).reshape(n * FP.shape[2], -1) @ y.reshape(len(y), -1).T
    b = b.reshape(n, FP.shape[2], len(y)) - np.einsum("nrij,nrj->ni", FP, mean)[..., None]
    A = np.einsum("nrg,nrh,nrij->ngihj", mixed, mixed, P, optimize=True).reshape(n, FP.shape[2], -1)
    log_det = fine.log_det[:, runs].sum(axis=1)
    found = np.empty((n, len(KAPPA), len(y)))
    for k, kappa in enumerate(KAPPA):
        # Woodbury: the offset adds a matrix of rank 3 Q to the block diagonal.
        inner = np.linalg.inv(prior) + A / kappa**2
        explained = np.einsum("nis,nis->ns", b, np.linalg.solve(inner, b)) / kappa**4
        volume = np.linalg.slogdet(inner)[1] + np.linalg.slogdet(prior)[1] + log_det
        constant = volume + size * (2 * np.log(kappa) + np.log(2 * np.pi))
        found[:, k] = -0.5 * (squares / kappa**2 - explained + constant[:, None])
    return found


def _prior(offset: Array, quantities: list[int]) -> Array:
    count = len(offset) // 4
    index = [4 * group + q for group in range(count) for q in quantities]
    return offset[np.ix_(index, index)]


def offsets_found(fine: Fine, node: int, kappa: float, y: Array, offset: Array) -> Array:
    """Return the most probable ``F_i delta`` ``(R, Q)`` given curves ``(R, 4)`` at a node."""
    q = list(fine.quantities)
    P, mixed = fine.precision[node] / kappa**2, fine.shares[node]
    size = mixed.shape[1] * len(q)
    b = np.einsum("rg,rij,rj->gi", mixed, P, y[:, q] - fine.mean[node]).ravel()
    A = np.einsum("rg,rh,rij->gihj", mixed, mixed, P).reshape(size, size)
    delta = np.linalg.solve(np.linalg.inv(_prior(offset, q)) + A, b)
    return mixed @ delta.reshape(-1, len(q))


@dataclass(frozen=True, eq=False)
class Weighed:
    """The support of a candidate by one set of curves.

    Attributes:
        log_evidence: Logarithm of the likelihood averaged over the priors of magnitudes and kappa.
        log_peak: Its highest value. best: ``(k,)`` magnitudes there [SI]. kappa: there.
        intervals: ``{level: (k, 2)}``, equal-tailed, of each magnitude [SI]. median: ``(k,)``.
        at_edge: ``(k,)`` bool: the peak lies at an end of the range. node: index of the peak.
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


def weigh(fine: Fine, y: Array, offset: Array, use: Array | None = None) -> list[Weighed]:
    """Return the support of a candidate by each of S sets of curves; arguments as for ``log_likelihood``."""
    found = log_likelihood(fine, y, offset, use)
    return [_weighed(fine, found[..., s]) for s in range(found.shape[-1])]


def _weighed(fine: Fine, found: Array) -> Weighed:
    total = float(logsumexp(found))
    node, k = np.unravel_index(int(np.argmax(found)), found.shape)
    weights = np.exp(logsumexp(found, axis=1) - total)
    median, edge = [], []
    intervals: dict[float, list[tuple[float, float]]] = {level: [] for level in LEVELS}
    for axis in range(fine.nodes.shape[1]):
        values, inverse = np.unique(fine.nodes[:, axis], return_inverse=True)
        share = np.bincount(inverse, weights=weights)
        cumulative = np.cumsum(share) / share.sum()
        middle = cumulative - 0.5 * share / share.sum()

        def at(p: float, middle: Array = middle, values: Array = values) -> float:
            return float(np.exp(np.interp(p, middle, np.log(values))))

        median.append(at(0.5))
        for level in LEVELS:
            intervals[level].append((at(0.5 - level / 2), at(0.5 + level / 2)))
        edge.append(fine.nodes[node, axis] in (values[0], values[-1]))
    return Weighed(
        log_evidence=total - float(np.log(found.size)),
        log_peak=float(found[node, k]),
        best=fine.nodes[node],
        kappa=float(KAPPA[k]),
        median=np.array(median),
        intervals={level: np.array(ends).reshape(-1, 2) for level, ends in intervals.items()},
        at_edge=np.array(edge, dtype=bool),
        node=int(node),
    )


def held_out(fine: Fine, y: Array, offset: Array, groups: Array) -> dict[str, float]:
    """Return for every curve the logarithm of its probability given the others, ``p(all) / p(others)``.

    Args:
        fine, offset: As for ``log_likelihood``. y: ``(R, 4)``. groups: ``(R,)``, name of the curve of each run.
    """
    whole = logsumexp(log_likelihood(fine, y[None], offset))
    return {
        str(name): float(whole - logsumexp(log_likelihood(fine, y[None], offset, groups != name)))
        for name in dict.fromkeys(groups)
    }
