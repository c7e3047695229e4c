"""Learned compensation on measured arms: the error that geometry leaves, as a function of the joint angles, without naming a cause.

Both learners are given the residual of each pose in metres, ``y_k = d_k . e(q)`` for one or more directions ``d_k``: three for a tracker, the
normal of the target plane for a contact. They see the angles as ``(sin q, cos q)``, so that a turn changes nothing.

``Process`` is three independent Gaussian processes with one kernel (see ``compensation``). ``Network`` has two hidden layers of ``HIDDEN`` units
with tanh, trained by Adam on the squared residual with decay of the weights; it stops where blocks of training poses that it does not
fit are predicted best, and is the mean of ``MEMBERS`` networks from different starts.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from benchmarks.diagnosis.compensation import LENGTHS, SHARES, squared_chords
from scalar.geometry.se3 import Array

HIDDEN, MEMBERS = 48, 3
STEPS, PATIENCE, RATE, DECAY = 1500, 150, 3e-3, 1e-4
STOPPING_FOLDS = 5
"""The poses of every fifth block tell a network when to stop."""


class Process:
    """Gaussian process of the error over the joint angles; size, length and noise are those of greatest evidence on a grid."""

    def __init__(self, q: Array, directions: Array, residual: Array) -> None:
        """Fit the process.

        Args:
            q: ``(N, n)`` [rad]. directions: ``(N, m, 3)``, of unit length; with m = 3 they are those of one frame.
            residual: ``(N, m)`` [m].
        """
        self.q = q
        self.directions = directions if directions.shape[1] == 1 else None
        scale = max(float(np.mean(residual**2)), 1e-300)
        along = directions[:, 0] @ directions[:, 0].T if self.directions is not None else 1.0
        chords = squared_chords(q, q)
        none = -0.5 * residual.size * (1.0 + np.log(2 * np.pi * scale))
        self.length, self.size, self.weights, best = 1.0, 0.0, np.zeros_like(residual), none
        for length in LENGTHS:
            kernel = along * np.exp(-0.5 * chords / length**2)
            for share in SHARES:
                covariance = share * scale * kernel
                covariance[np.diag_indices(len(q))] += (1 - share) * scale
                factor = cho_factor(covariance, lower=True, overwrite_a=True)
                weights = cho_solve(factor, residual)
                log_det = 2.0 * float(np.log(np.diag(factor[0])).sum()) * residual.shape[1]
                evidence = -0.5 * (
                    float(np.sum(residual * weights)) + log_det + residual.size * np.log(2 * np.pi)
                )
                if evidence > best:
                    best, self.length, self.size, self.weights = evidence, length, share * scale, weights

    def predicted(self, q: Array, directions: Array) -> Array:
        """Return the expected residual ``(P, m)`` [m] at joint angles ``(P, n)`` along ``directions`` ``(P, m, 3)``."""
        kernel = self.size * np.exp(-0.5 * squared_chords(q, self.q) / self.length**2)
        if self.directions is None:
            return kernel @ self.weights
        error = kernel @ (self.weights * self.directions[:, 0])
        return np.einsum("pmi,pi->pm", directions, error)


class Network:
    """Mean of small networks from the joint angles to the error of the position."""

    def __init__(
        self, q: Array, directions: Array, residual: Array, block: Array, rng: np.random.Generator
    ) -> None:
        """Train the networks.

        Args:
            q: ``(N, n)`` [rad]. directions: ``(N, m, 3)``. residual: ``(N, m)`` [m].
            block: ``(N,)``, of successive poses; those of every fifth block tell when to stop, another fifth for each network.
            rng: Of the starts.
        """
        self.scale = max(float(np.sqrt(np.mean(residual**2))), 1e-300)
        inputs = _inputs(q)
        self.members = [
            _trained(inputs, directions, residual / self.scale, block % STOPPING_FOLDS == k, rng)
            for k in range(MEMBERS)
        ]

    def predicted(self, q: Array, directions: Array) -> Array:
        """Return the expected residual ``(P, m)`` [m] at joint angles ``(P, n)`` along ``directions`` ``(P, m, 3)``."""
        error = np.mean([_forward(weights, _inputs(q))[-1] for weights in self.members], axis=0)
        return self.scale * np.einsum("pmi,pi->pm", directions, error)


def _inputs(q: Array) -> Array:
    return np.column_stack([np.sin(q), np.cos(q)])


def _forward(weights: list[Array], inputs: Array) -> list[Array]:
    """Return the values of both hidden layers and the error ``(P, 3)`` in units of the residual's size."""
    W1, b1, W2, b2, W3, b3 = weights
    first = np.tanh(inputs @ W1 + b1)
    second = np.tanh(first @ W2 + b2)
    return [first, second, second @ W3 + b3]


def _trained(
    inputs: Array, directions: Array, target: Array, out: Array, rng: np.random.Generator
) -> list[Array]:
    """Return the weights with which the poses left ``out`` are predicted best; without a network they are predicted to be zero."""
    sizes = (inputs.shape[1], HIDDEN, HIDDEN, 3)
    weights: list[Array] = []
    for a, b in pairwise(sizes):
        weights += [rng.standard_normal((a, b)) / np.sqrt(a), np.zeros(b)]
    weights[4] *= 0.0
    mean, square = ([np.zeros_like(w) for w in weights] for _ in range(2))
    best, kept, since = np.inf, [w.copy() for w in weights], 0
    x, d, y = inputs[~out], directions[~out], target[~out]
    for step in range(1, STEPS + 1):
        left = np.einsum("pmi,pi->pm", directions[out], _forward(weights, inputs[out])[-1]) - target[out]
        loss = float(np.mean(left**2))
        best, kept, since = (loss, [w.copy() for w in weights], 0) if loss < best else (best, kept, since + 1)
        if since > PATIENCE:
            break
        for w, g, m, v in zip(weights, _gradient(weights, x, d, y), mean, square, strict=True):
            m += 0.1 * (g - m)
            v += 0.001 * (g**2 - v)
            w -= RATE * (m / (1 - 0.9**step) / (np.sqrt(v / (1 - 0.999**step)) + 1e-8) + DECAY * w)
    return kept


def _gradient(weights: list[Array], x: Array, d: Array, y: Array) -> list[Array]:
    """Return the gradient of the mean squared residual by each array of weights."""
    first, second, error = _forward(weights, x)
    left = np.einsum("pmi,pi->pm", d, error) - y
    by_error = 2.0 * np.einsum("pm,pmi->pi", left, d) / left.size
    by_second: Any = by_error @ weights[4].T * (1 - second**2)
    by_first: Any = by_second @ weights[2].T * (1 - first**2)
    return [
        x.T @ by_first, by_first.sum(axis=0),
        first.T @ by_second, by_second.sum(axis=0),
        second.T @ by_error, by_error.sum(axis=0),
    ]  # fmt: skip
