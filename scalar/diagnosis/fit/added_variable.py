"""An effect given all other free parameters: the part of its signal that they cannot fit, and the part of the residual that it explains.

The *signal* of an effect is the change of the whitened rows that its fitted coefficients make. By the theorem of Frisch, Waugh and Lovell, the slope
of the residual over the signal, after the columns of everything else are projected out of both, is that of the joint fit: the added-variable plot.
"""

from __future__ import annotations

import numpy as np

from scalar.diagnosis.fit.fitted_state import FittedState
from scalar.effects.picture import Axis, Profile
from scalar.geometry.se3 import Array


def added_variable(state: FittedState, index: int, residual: Array) -> Profile:
    """Return the added-variable plot of an effect: the measured shift over the predicted shift, both without what other parameters can fit.

    It is drawn for effects that are no function of a single variable. The slope is one if the effect explains the residual.

    Args:
        state: The state with the effect.
        index: Index of the effect in ``state.effects``.
        residual: ``(N, m)``, whitened residual of the state.
    """
    N, m = residual.shape
    jacobian = state.linearised()[1]
    mine, coefficients = _free_part(state, index)
    J = jacobian[:, ~mine]
    lengths = np.linalg.norm(J, axis=0)
    Q = np.linalg.qr(J[:, lengths > 0] / lengths[lengths > 0])[0]
    signal = jacobian[:, mine] @ coefficients
    left = (signal - Q @ (Q.T @ signal))[: N * m].reshape(N, m)
    x, rest, std = state.residuals.measurement.shift(left, residual)
    ends = np.array([float(x.min()), float(x.max())])
    curve = np.stack([ends, ends, np.zeros(2)])
    note = "What the other parameters would take up is removed from both."
    x_axis, y_axis = Axis("shift that the effect predicts", "m"), Axis("shift that is measured", "m")
    return Profile(x_axis, y_axis, x, x - rest, -rest, std, x, curve, note=note)


def share_left(state: FittedState, index: int, gram: Array) -> float:
    """Return the share, 0 to 1, of the length of an effect's signal that no other parameter can absorb.

    With G the Gram matrix of all free columns, e the effect's columns and o the others, the Gram matrix of what is left of the effect's columns is
    the Schur complement ``S = G_ee - G_eo G_oo^+ G_oe``. With c the effect's coefficients, the share is ``sqrt(c' S c / c' G_ee c)``.

    Args:
        state: The state with the effect.
        index: Index of the effect in ``state.effects``.
        gram: ``(F, F)``, G.
    """
    mine, c = _free_part(state, index)
    scale = np.sqrt(np.maximum(np.diag(gram), 1e-300))
    G = gram / np.outer(scale, scale)
    c = c * scale[mine]
    whole = float(c @ G[np.ix_(mine, mine)] @ c)
    across = G[np.ix_(~mine, mine)] @ c
    absorbed = float(across @ np.linalg.lstsq(G[np.ix_(~mine, ~mine)], across, rcond=1e-12)[0])
    return float(np.sqrt(np.clip((whole - absorbed) / whole, 0.0, 1.0))) if whole > 0 else 0.0


def _free_part(state: FittedState, index: int) -> tuple[Array, Array]:
    """Return which of the F free columns are an effect's ``(F,)`` bool, and those of its coefficients that are free ``(k,)``."""
    start = state.model.blocks["effects"].start + sum(len(e.coefficients) for e in state.effects[:index])
    own = np.zeros(len(state.free), dtype=bool)
    own[start : start + len(state.effects[index].coefficients)] = True
    return own[state.free], state.model.vector[own & state.free]
