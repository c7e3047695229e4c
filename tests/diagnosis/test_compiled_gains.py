"""Gains that the compiled library computes are those of the reference in NumPy."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from scalar import kernels
from scalar.diagnosis.beam_search import SearchElements
from scalar.diagnosis.score_test import shrunk_gain

needs_library = pytest.mark.skipif(kernels.LIBRARY is None, reason="no compiled kernels here: no C compiler")


def in_numpy(compute):
    """Return what a function returns without the compiled library."""
    library, kernels.LIBRARY = kernels.LIBRARY, None
    try:
        return compute()
    finally:
        kernels.LIBRARY = library


def products(rng, count, rows=60):
    """Return inner products ``(count, count)`` of columns of very different lengths, some alike, and their projections on a residual."""
    E = rng.normal(size=(rows, count)) * 10.0 ** rng.uniform(-2, 3, count)
    E[:, -1] = E[:, 0] * (1 + 1e-3 * rng.normal())
    return E.T @ E, E.T @ rng.normal(size=rows), rows


def elements_of(rng, widths):
    """Return search elements with these numbers of columns."""
    ends = np.cumsum([0, *widths])
    gram, projection, rows = products(rng, ends[-1])
    columns = [np.arange(*ends_of_one) for ends_of_one in pairwise(ends)]
    largest = np.full(len(gram), np.inf)
    return SearchElements(
        columns, np.arange(len(widths)), gram, projection, 1e4, rows, len(widths), 1e-6, largest
    )


@needs_library
@given(st.integers(1, 20), st.integers(1, 5), st.integers(0, 2**32 - 1))
@settings(max_examples=30)
def test_gains_are_those_of_the_eigenvalues(width, count, seed):
    """For any positive matrices, the gain and the number of directions agree with those computed from LAPACK's eigenvalues."""
    rng = np.random.default_rng(seed)
    grams, projections = (
        np.array(x) for x in zip(*(products(rng, width + 1)[:2] for _ in range(count)), strict=True)
    )
    grams, projections = grams[:, :width, :width], projections[:, :width]
    gains, dofs = shrunk_gain(grams, projections)
    values, vectors = np.linalg.eigh(grams)
    along = np.einsum("tei,te->ti", vectors, projections)
    expected = np.sum(np.where(values > 1, along**2 / (1 + np.maximum(values, 0)), 0), axis=1)
    np.testing.assert_allclose(gains, expected, rtol=1e-7)
    np.testing.assert_array_equal(dofs, np.sum(values > 1, axis=1))


@needs_library
@given(st.lists(st.integers(1, 6), min_size=5, max_size=12), st.integers(0, 2**32 - 1))
@settings(max_examples=30)
def test_sets_and_extensions_agree_with_numpy(widths, seed):
    """For elements with any numbers of columns, squared residuals, evidence and extensions of sets agree with those computed by NumPy."""
    elements = elements_of(np.random.default_rng(seed), widths)
    sets = [(), (0,), (1, 3), (0, 2, 4)]
    found, expected = elements.subsets(sets), in_numpy(lambda: elements.subsets(sets))
    for ours, theirs in zip(found, expected, strict=True):
        assert ours.sum_of_squares == pytest.approx(theirs.sum_of_squares, rel=1e-8)
        assert ours.evidence == pytest.approx(theirs.evidence, rel=1e-8)
    gains, dofs = elements._gains_given(found)
    by_numpy = in_numpy(lambda: elements._gains_given(found))
    others = np.array([[k not in one.elements for k in range(len(widths))] for one in found])
    np.testing.assert_allclose(gains[others], by_numpy[0][others], rtol=1e-5, atol=1e-7)
    np.testing.assert_array_equal(dofs[others], by_numpy[1][others])
