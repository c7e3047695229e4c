"""MINPACK's Levenberg-Marquardt method (lmder, Moré 1978) as SciPy has it, kept from reading memory that is not its own.

SciPy's translation to C (1.15 to 1.17) computes the norm of what is left of a column anew where little is left of it, and takes one number too
many: the first of the next column, and after the last column whatever the memory holds there. Which column is eliminated next, and with it the
last bits of every step, then depend on that number: the same problem ends differently from one process to the next where last bits matter.

So MINPACK is given two parameters and two rows more than the problem has, ``0 = large * u`` and ``0 = tiny * v`` with ``u = v = 0``. The column of u
is longer than all others, so it is eliminated first, and leaves zeros where the norms look too far; that of v stays the last, and its norm is
never computed anew. Neither changes a step, a norm or a test of convergence.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from scalar.geometry.se3 import Array

TINY = 1e-100  # shorter than any column that a problem has; its square is still a number


def levenberg_marquardt(
    residual: Callable[[Array], Array],
    jacobian: Callable[[Array], Array],
    x: Array,
    *,
    ftol: float = 1.49012e-8,
    xtol: float = 1.49012e-8,
    gtol: float = 0.0,
    max_evaluations: int,
    factor: float = 100.0,
) -> tuple[Array, str, int]:
    """Return where lmder ends ``(F,)``, its message, and its ``info``: 1 to 4 where it converged.

    Args:
        residual: ``(R,)`` at coordinates ``(F,)``.
        jacobian: ``(R, F)`` there.
        x: ``(F,)``, the start.
        ftol: Relative reduction of the sum of squares below which it ends.
        xtol: Relative change of the coordinates below which it ends.
        gtol: Cosine between the residual and any column below which it ends.
        max_evaluations: Calls of the residual after which it gives up.
        factor: First bound of a step, in lengths of the scaled coordinates.
    """
    from scipy.optimize import leastsq  # slow to import

    def guarded_residual(guarded: Array) -> Array:
        return np.concatenate([[0.0], residual(guarded[1:-1]), [0.0]])

    def guarded_jacobian(guarded: Array) -> Array:
        """Return the Jacobian ``(R + 2, F + 2)`` between two guards: a first column that is longer than any other, and a last one that is tiny."""
        J = jacobian(guarded[1:-1])
        extended = np.zeros((len(J) + 2, J.shape[1] + 2))
        extended[1:-1, 1:-1] = J
        lengths = np.sqrt(np.einsum("rf,rf->f", J, J))
        extended[0, 0] = 2.0 * np.max(lengths, initial=1.0, where=np.isfinite(lengths))
        extended[-1, -1] = TINY
        return extended

    found: Any = leastsq(
        guarded_residual,
        np.concatenate([[0.0], x, [0.0]]),
        Dfun=guarded_jacobian,
        full_output=True,  # else it warns where it says no more than that it stopped
        ftol=ftol,
        xtol=xtol,
        gtol=gtol,
        maxfev=max_evaluations,
        factor=factor,  # type: ignore[arg-type]  # a float, whatever the stubs say
    )
    return found[0][1:-1], " ".join(str(found[3]).split()), int(found[4])
