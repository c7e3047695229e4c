"""Where two effects that the data do not distinguish would predict different positions: the poses to add.

On the data one effect, and the best mixture of the other and the geometry, leave the same residual; within
the joint limits they need not. Poses drawn there at random are compared, and the part of one joint's range
where the two disagree most is named.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from scalar.diagnosis.fitted_state import FittedState, whitened
from scalar.diagnosis.predicted_displacements import displacements, joint_limits, random_poses
from scalar.effects import Effect
from scalar.geometry.se3 import Array

PARTS = 6  # into which a joint's range is divided


@dataclass(frozen=True)
class Separation:
    """Where two effects disagree.

    Attributes:
        joint: Number, from 1, of the joint whose position matters most.
        low, high: The part of its range where they disagree most, in its unit.
        unit: ``rad``, or ``m`` where the joint slides.
        there: Root mean square disagreement of predicted positions in that part of the range [m].
        here: The same at the poses that were measured [m].
    """

    joint: int
    low: float
    high: float
    unit: str
    there: float
    here: float


def separation(state: FittedState, index: int, other: Effect) -> Separation | None:
    """Return where effect ``index`` of a state and another would be distinguished; None if one of them depends on more than joint angles, or
    if the difference cannot be computed.
    """
    effect = state.effects[index]
    if not (effect.acts_by_joint_angles and other.acts_by_joint_angles):
        return None
    steps = _steps(state, index, other)
    if steps is None:
        return None
    limits, seen, anywhere = joint_limits(state), state.residuals.poses, random_poses(state)
    q = anywhere.q
    here, there = (displacements(state, [other], steps, poses) for poses in (seen, anywhere))
    best: tuple[float, int, float, float] | None = None
    for j in range(len(limits)):
        edges = np.linspace(limits[j][0], limits[j][1], PARTS + 1)
        part = np.clip(np.digitize(q[:, j], edges) - 1, 0, PARTS - 1)
        means = np.array([np.mean(there[part == k] ** 2) for k in range(PARTS)])
        k = int(np.argmax(means))
        if best is None or means[k] > best[0]:
            best = float(means[k]), j + 1, float(edges[k]), float(edges[k + 1])
    assert best is not None
    rms = float(np.sqrt(np.mean(here**2)))
    unit = "m" if state.model.robot.slides[best[1] - 1] else "rad"
    return Separation(best[1], best[2], best[3], unit, float(np.sqrt(best[0])), rms)


def _steps(state: FittedState, index: int, other: Effect) -> Array | None:
    """Return by how much the parameters differ between the two explanations, ``(P + k,)``, the other effect's k coefficients last."""
    # Both whitened for the variance between poses: rows of two whitenings cannot be compared.
    J = whitened(state.whitening, state.residuals.linearise(state.model)[1])
    E = state.columns_of([other])
    J, E = J[: len(E)], E[: len(J)]
    start = state.model.blocks["effects"].start + sum(len(e.coefficients) for e in state.effects[:index])
    mine = slice(start, start + len(state.effects[index].coefficients))
    free = state.free.copy()
    free[mine] = False
    c = state.effects[index].coefficients
    A = np.concatenate([J[:, free], E], axis=1)
    scale = np.linalg.norm(A, axis=0)
    scale[scale == 0] = 1.0
    found = np.linalg.lstsq(A / scale, J[:, mine] @ c, rcond=1e-8)[0] / scale
    if not np.all(np.isfinite(found)):
        return None
    steps = np.zeros(J.shape[1] + E.shape[1])
    steps[mine] = c
    steps[: J.shape[1]][free] -= found[: int(free.sum())]
    steps[J.shape[1] :] -= found[int(free.sum()) :]
    return steps
