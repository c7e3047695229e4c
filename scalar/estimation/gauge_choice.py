"""Which parameters to fix so that the others are determined: one for each direction that no measurement observes.

QR with column pivoting on the null space finds a well-conditioned choice (rank-revealing QR: Golub and Van Loan, 5.4). The parameters of the
base and of the flange, whose places are conventions, are preferred wherever they leave the remaining problem nearly as well conditioned.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg.lapack import dgeqp3, dpotrf  # pyright: ignore[reportAttributeAccessIssue]  # made by f2py

from scalar.estimation.settings import IdentifiabilitySettings
from scalar.geometry.parallel_axes import near_parallel
from scalar.geometry.robot import GEOMETRY, Robot
from scalar.geometry.se3 import Array

_BEYOND_ROUNDING = 1.01  # factor on a bound of a singular value, so that rounding does not decide


def preference(robot: Robot, names: tuple[str, ...]) -> list[int]:
    """Return the indices of the candidates in the order in which they would be fixed: first those that are conventions or best known.

    The order is: the base's parameters; the flange's; the place of a prismatic joint, since only its direction moves the arm; d of an axis that
    is parallel to the next one; the other lengths of the robot, the longest first, since one of them has to set the scale; its angles; the
    sensor; the target.
    """
    n = robot.n_joints
    near = near_parallel(robot)
    rank: dict[str, tuple[float, float]] = {}
    for i in range(n):
        for k, kind in enumerate(GEOMETRY):
            value = abs(float(robot.geometry[k, i]))
            if i == 0:
                key = (0.0, k)
            elif i == n - 1 and kind in ("d", "theta"):
                key = (1.0, k)
            elif kind in ("a", "d") and i in robot.prismatic:
                key = (1.5, i)
            elif kind == "d" and i + 1 < n and near[i + 1]:
                key = (2.0, i)
            elif kind in ("a", "d"):
                key = (3.0, -value)
            else:
                key = (4.0, i)
            rank[f"{kind}_{i + 1}"] = key
    unknown = [(5.0 if name.startswith("sensor_") else 6.0, float(i)) for i, name in enumerate(names)]
    keys = [rank.get(name, unknown[i]) for i, name in enumerate(names)]
    return sorted(range(len(names)), key=lambda i: keys[i])


def choose_fixed(
    null: Array, order: list[int], scaled: Array, settings: IdentifiabilitySettings
) -> list[int]:
    """Return the indices of the candidates to fix, one for each null direction.

    The preferred set is taken unless it leaves the Jacobian much worse conditioned than the rank-revealing one.

    Args:
        null: ``(C, r)``, orthonormal null space of the scaled Jacobian.
        order: Indices of the candidates, the preferred first, as ``preference`` gives them.
        scaled: ``(rows, C)``, the scaled Jacobian or, to save time, its triangular factor, whose columns have the same lengths and angles.
        settings: Thresholds.
    """
    r = null.shape[1]
    if r == 0:
        return []
    chosen: list[int] = []
    basis = np.zeros((0, r))
    for i in order:
        rest = null[i] - basis.T @ (basis @ null[i])
        length = float(np.sqrt(rest @ rest))
        if length > settings.span_tolerance:
            chosen.append(i)
            basis = np.vstack([basis, rest / length])
            if len(chosen) == r:
                break
    revealing = [i - 1 for i in dgeqp3(null.T)[1][:r].tolist()]  # QR with column pivoting
    if len(chosen) < r:
        return revealing
    if set(chosen) == set(revealing):
        return chosen
    preferred, other = (np.delete(scaled, fixed, axis=1) for fixed in (chosen, revealing))
    # The smallest singular value of columns is no larger than the shortest column, so this bound is sufficient.
    enough = float(np.sqrt(np.einsum("rc,rc->c", other, other).min())) / settings.condition_slack
    if _exceeds_surely(preferred, _BEYOND_ROUNDING * enough):
        return chosen
    least, best = (float(np.linalg.svd(kept, compute_uv=False)[-1]) for kept in (preferred, other))
    return revealing if least < best / settings.condition_slack else chosen


def _exceeds_surely(columns: Array, least: float) -> bool:
    """Return whether a Cholesky factor proves that the smallest singular value of columns ``(rows, k)`` exceeds ``least``.

    It takes a tenth of the time of the singular values. False does not mean that the value is smaller.
    """
    gram = columns.T @ columns
    gram[np.diag_indices_from(gram)] -= least**2
    return dpotrf(gram)[1] == 0
