"""The motion of the tracker relative to the robot's base during a campaign, from reference nests on the base.

A nest is fixed to the base and measured at the poses, so its measured position changes if the tracker moves: with c its position at the first
pose and r the vector from the middle of all nests to it, the position measured at pose i is ``y_i = c + t_i + w_i x r`` plus noise. The motion
(w, t) is modelled as a random walk from zero. The size of its steps and the noise of the nests are estimated by restricted maximum likelihood
(Patterson and Thompson, 1971), and the most probable walk given all measurements is returned. Three nests that are not on a line determine the whole
motion; with fewer, undetermined parts stay zero. Rotations are linearised, which is accurate for less than a degree.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import sparse
from scipy.optimize import minimize_scalar
from scipy.sparse.linalg import splu
from scipy.special import chdtrc

from scalar.data.references import References
from scalar.geometry.screws import change_frame
from scalar.geometry.se3 import Array, inverse, skew

_REACH = 1.0  # m; a step's rotation shifts points at this distance as much as its translation does
_RATIOS = (1e-4, 1e2)  # bounds of the ratio of a step to the noise
_ALPHA = 1e-4  # p-value below which a motion is significant


@dataclass(frozen=True, eq=False)
class ObservedMotion:
    """The motion of the base relative to the tracker in one session, as its nests show it.

    Attributes:
        screws: ``(N, 6)`` [rad, m], motion (w, v) about the tracker's origin since the first pose, in the tracker's frame; zero if
            no motion is significant.
        step: Standard deviation of the step between two poses: that of each translation [m]; divided by ``_REACH``, that of each rotation [rad].
        noise: Standard deviation of a coordinate of a nest [m]; NaN if no nest was measured twice, which shows no motion either.
        p_value: p-value of the hypothesis that nothing moves.
    """

    screws: Array
    step: float
    noise: float
    p_value: float


def motion_of_base(references: References, session: Array, T_tracker_base: Array) -> Array:
    """Return the motion of the base relative to the tracker ``(N, 6)`` [rad, m], in the base frame, at the poses of all S sessions.

    After the last pose of a session at which a nest was measured, the motion is taken to stay the same.

    Args:
        references: The nests as measured in the tracker's frame.
        session: ``(N,)`` int, session of each pose.
        T_tracker_base: ``(S, 4, 4)``, the base's frame in the tracker's in each session.
    """
    found = np.zeros((len(session), 6))
    for s, T in enumerate(T_tracker_base):
        rows = np.flatnonzero(session == s)
        of_session = references.subset(rows, len(session))
        if len(of_session.pose):
            screws = observed_motion(of_session).screws
            back = np.broadcast_to(inverse(T), (len(screws), 4, 4))
            found[rows[: len(screws)]] = change_frame(back, screws[:, :, None])[:, :, 0]
            found[rows[len(screws) :]] = found[rows[len(screws) - 1]]
    return found


def observed_motion(references: References) -> ObservedMotion:
    """Return the motion over the poses ``0 .. N - 1`` of one session from its nests; pose N - 1 is the last at which a nest was measured."""
    n = int(references.pose.max()) + 1
    if len(references.pose) == len(np.unique(references.item)):
        return ObservedMotion(np.zeros((n, 6)), 0.0, np.nan, 1.0)
    system = _System.of(references, n)
    cost_at_rest = system.cost_without_motion()
    found: Any = minimize_scalar(
        lambda log: system.solved(float(np.exp(log)))[0], bounds=tuple(np.log(_RATIOS)), method="bounded"
    )
    ratio = float(np.exp(found.x))
    cost, noise, motion = system.solved(ratio)
    p = float(0.5 * chdtrc(1, max(cost_at_rest - cost, 0.0)))
    moves = p < _ALPHA
    w, t = motion[:, :3], motion[:, 3:]
    screws = np.concatenate([w, t - np.cross(w, system.middle)], axis=1) if moves else np.zeros((n, 6))
    return ObservedMotion(screws, ratio * noise, noise, p)


@dataclass(frozen=True, eq=False)
class _System:
    """The mixed model of Q measurements of nests: ``y = X c + Z x + e``.

    Attributes:
        X: ``(3 Q, 3 K)``, sparse, for the positions c of K nests.
        Z: ``(3 Q, 6 (n - 1))``, sparse, for the walk x after the first pose; its rotations are in units of ``1 / _REACH``.
        y: ``(3 Q,)`` [m], measured positions about each nest's mean. Rows of y, X and Z are multiplied by the median noise over that of the row.
        D: ``(6 (n - 1), 6 (n - 1))``, sparse, the differences of successive poses.
        middle: ``(3,)`` [m], mean position of the nests.
    """

    X: Any  # SciPy does not state the types of sparse matrices
    Z: Any
    y: Array
    D: Any
    middle: Array

    @classmethod
    def of(cls, references: References, n: int) -> _System:
        """Return the system of nests over n poses."""
        Q = len(references.pose)
        places = np.array(
            [references.points[references.item == k].mean(axis=0) for k in np.unique(references.item)]
        )
        item = np.unique(references.item, return_inverse=True)[1]
        K = len(places)
        middle = places.mean(axis=0)
        weight = np.ones(Q)
        if references.noise is not None:
            weight = np.median(references.noise) / references.noise
        rows = np.arange(3 * Q).reshape(Q, 3)
        eye = np.broadcast_to(np.eye(3), (Q, 3, 3)) * weight[:, None, None]
        X = _placed(eye, rows, 3 * item[:, None] + np.arange(3), (3 * Q, 3 * K))
        turn = -skew((places - middle)[item]) / _REACH * weight[:, None, None]
        after = references.pose > 0
        blocks = np.concatenate([turn, eye], axis=2)[after]
        Z = _placed(
            blocks, rows[after], 6 * (references.pose[after, None] - 1) + np.arange(6), (3 * Q, 6 * (n - 1))
        )
        one = sparse.dia_array((np.array([[1.0], [-1.0]]) * np.ones(n - 1), [0, -1]), shape=(n - 1, n - 1))
        y = ((references.points - places[item]) * weight[:, None]).ravel()
        return cls(X, Z, y, sparse.csr_matrix(sparse.kron(one, sparse.eye(6))), middle)

    def cost_without_motion(self) -> float:
        """Return minus twice the restricted log likelihood if nothing moves."""
        gram = (self.X.T @ self.X).toarray()
        rest = self.y - self.X @ np.linalg.solve(gram, self.X.T @ self.y)
        freedom = len(self.y) - len(gram)
        return freedom * float(np.log(max(rest @ rest, 1e-300) / freedom)) + float(np.linalg.slogdet(gram)[1])

    def solved(self, ratio: float) -> tuple[float, float, Array]:
        """Return minus twice the restricted log likelihood, the noise [m], and the motion ``(n, 6)`` (w, t), for a ratio of step to noise."""
        # The matrix is banded, with a border for the positions of the nests; in this order of its rows its factors have no other entries.
        ZX = sparse.hstack([self.Z, self.X])
        K, walk = self.X.shape[1], self.Z.shape[1]
        precision = sparse.block_diag([self.D.T @ self.D / ratio**2, sparse.csr_matrix((K, K))])
        symmetric = {"SymmetricMode": True}
        matrix = sparse.csc_matrix(ZX.T @ ZX + precision)
        factor = splu(matrix, permc_spec="NATURAL", diag_pivot_thresh=0.0, options=symmetric)
        right = ZX.T @ self.y
        solution = factor.solve(right)
        freedom = len(self.y) - K
        squares = max(float(self.y @ self.y - right @ solution), 1e-300)
        logdet = float(np.sum(np.log(np.abs(factor.U.diagonal()))))
        cost = freedom * float(np.log(squares / freedom)) + logdet + 2 * walk * float(np.log(ratio))
        motion = np.zeros((walk // 6 + 1, 6))
        motion[1:] = solution[:walk].reshape(-1, 6) / np.r_[np.full(3, _REACH), np.ones(3)]
        return cost, float(np.sqrt(squares / freedom)), motion


def _placed(blocks: Array, rows: Array, columns: Array, shape: tuple[int, int]) -> sparse.csr_matrix:
    """Return a sparse matrix of dense blocks ``(B, 3, w)`` at rows ``(B, 3)`` and columns ``(B, w)``."""
    i = np.broadcast_to(rows[:, :, None], blocks.shape).ravel()
    j = np.broadcast_to(columns[:, None, :], blocks.shape).ravel()
    return sparse.csr_matrix((blocks.ravel(), (i, j)), shape=shape)
