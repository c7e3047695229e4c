"""Compute gains of candidates and of sets of elements in the compiled library, from inner products of columns in units of their priors.

The gain of columns is the drop of the penalised sum of squares when they are added to a model.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from scalar import kernels
from scalar.kernels import NOT_POSITIVE, Array, address, checked, contiguous

IntArray = NDArray[np.int64]


def shrunk_gains(grams: Array, projections: Array) -> tuple[Array, IntArray] | None:
    """Return gains ``(T,)`` and degrees of freedom ``(T,)`` as ``scalar.diagnosis.scoring.score_test.shrunk_gain``; None without the library.

    Args:
        grams: ``(T, w, w)``, inner products of the w columns of each of T candidates.
        projections: ``(T, w)``, inner products of these columns with the residual.
    """
    T, w = projections.shape
    if kernels.LIBRARY is None:
        return None
    grams, projections, work = contiguous(grams), contiguous(projections), np.empty(w * (2 * w + 1))
    gain, seen = np.empty(T), np.empty(T, dtype=np.int64)
    kernels.LIBRARY.shrunk_gains(
        T, w, address(grams), address(projections), address(work), address(gain), address(seen)
    )
    return gain, seen


def chosen_forward(gram: Array, projection: Array, width: int, least: float) -> list[int] | None:
    """Return the indices of groups of columns that forward selection adds, as ``score_test.Projected.forward`` does; None without the library.

    Args:
        gram: ``(T w, T w)``, inner products of the columns of T groups, which follow one another.
        projection: ``(T w,)``, their inner products with the residual.
        width: w.
        least: Least gain of a group.
    """
    if kernels.LIBRARY is None:
        return None
    gram, projection = gram.copy(), projection.copy()
    work, chosen = np.empty(width * (len(gram) + 2 * width + 1)), np.empty(len(gram) // width, dtype=np.int64)
    n = kernels.LIBRARY.select_forward(
        len(chosen), width, address(gram), address(projection), least, address(work), address(chosen)
    )
    return chosen[:n].tolist()


def set_gains(gram: Array, projection: Array, columns: NDArray[np.intp]) -> tuple[Array, IntArray] | None:
    """Return for T sets of s columns each the gain ``(T,)``, the drop of the sum of squares with the penalty of the priors, and how many
    eigenvalues of the set's inner products exceed 1, ``(T,)``; None without the library, or if digits are lost.

    Args:
        gram: ``(e, e)``, inner products of all columns.
        projection: ``(e,)``, their inner products with the residual.
        columns: ``(T, s)``, indices of the columns of each set.
    """
    if kernels.LIBRARY is None:
        return None
    gram, projection = contiguous(gram), contiguous(projection)
    columns = np.ascontiguousarray(columns, dtype=np.int64)
    T, s = columns.shape
    gain, seen = np.empty(T), np.empty(T, dtype=np.int64)
    status = kernels.LIBRARY.set_gains(
        len(gram), address(gram), address(projection), T, s, address(columns), address(gain), address(seen)
    )  # fmt: skip
    return None if _failed(status) else (gain, seen)


def extension_gains(
    gram: Array, projection: Array, given: Sequence[NDArray[np.intp]], first: IntArray, width: IntArray
) -> tuple[Array, IntArray] | None:
    """Return gains and degrees of freedom ``(T, n)`` of n elements, conditional on each of T sets; None without the library, or if digits are lost.

    Args:
        gram: ``(e, e)``, inner products of all columns.
        projection: ``(e,)``, their inner products with the residual.
        given: The indices of the columns of each set. It is faster if sets that begin with the same columns follow one another.
        first: ``(n,)``, the first column of each element.
        width: ``(n,)``, how many columns it has; they follow one another.
    """
    if kernels.LIBRARY is None:
        return None
    gram, projection = contiguous(gram), contiguous(projection)
    ends = np.zeros(len(given) + 1, dtype=np.int64)
    np.cumsum([len(columns) for columns in given], out=ends[1:])
    columns = np.concatenate([np.zeros(0, dtype=np.int64), *given]).astype(np.int64)
    T, n = len(given), len(first)
    gain, seen = np.empty((T, n)), np.empty((T, n), dtype=np.int64)
    status = kernels.LIBRARY.extension_gains(
        len(gram), address(gram), address(projection), T, address(ends), address(columns), n, address(first),
        address(width), address(gain), address(seen),
    )  # fmt: skip
    return None if _failed(status) else (gain, seen)


def best_extensions(
    gain: Array,
    seen: IntArray,
    remaining: Array,
    least: float,
    log_penalty: float,
    begins: Sequence[int],
    most: int,
) -> list[list[int]] | None:
    """Return for each of T sets the elements that lower the cost ``max(remaining - gain, least) exp(log_penalty seen)`` most, the lowest first.

    Of each family, elements that follow one another, only the best is returned. None without the library.

    Args:
        gain: ``(T, n)``, by how much each element lowers what remains with a set; elements without a gain are left out.
        seen: ``(T, n)``, their degrees of freedom.
        remaining: ``(T,)``, what remains without them.
        least: The least that may remain.
        log_penalty: For each degree of freedom.
        begins: ``(F + 1,)``, the first element of each of the F families, and n.
        most: Largest number of elements for each set.
    """
    if kernels.LIBRARY is None:
        return None
    T, n = gain.shape
    gain, remaining, ends = contiguous(gain), contiguous(remaining), np.array(begins, dtype=np.int64)
    seen = np.ascontiguousarray(seen, dtype=np.int64)
    penalty = np.exp(log_penalty * np.arange(seen.max(initial=0) + 1))
    chosen = np.empty((T, most), dtype=np.int64)
    status = kernels.LIBRARY.best_extensions(
        T, n, len(ends) - 1, most, address(gain), address(seen), address(remaining), least, address(penalty), address(ends),
        address(chosen),
    )  # fmt: skip
    checked(status)
    return [[k for k in row if k >= 0] for row in chosen.tolist()]


def _failed(status: int) -> bool:
    """Return whether the library lost too many digits; any other failure raises an error."""
    if status == NOT_POSITIVE:
        return True
    checked(status)
    return False
