"""Gains that the compiled library computes are those of the reference in NumPy."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from scalar import kernels
from scalar.diagnosis.scoring.score_test import Projected, shrunk_gain
from scalar.diagnosis.selection.beam_search import SearchElements
from scalar.kernels.gains import chosen_forward, extension_gains, set_gains
from scalar.kernels.likelihood import restricted_likelihood

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
@given(st.integers(1, 48), st.integers(1, 5), st.integers(0, 2**32 - 1))
@settings(max_examples=60)
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


@needs_library
@given(st.lists(st.integers(1, 3), min_size=6, max_size=14), st.integers(1, 20), st.integers(0, 2**32 - 1))
@settings(max_examples=30)
def test_the_best_of_each_family_are_those_of_numpy(widths, most, seed):
    """Of families of several elements the best ones extend a set, as many as are asked for or as there are, and none that explains nothing."""
    rng = np.random.default_rng(seed)
    family = np.sort(rng.integers(0, 4, len(widths)))
    elements = replace(elements_of(rng, widths), family=family)
    sets = elements.subsets([(), (1,), (0, 3)])
    least = min(subset.sum_of_squares for subset in sets)
    gains = rng.uniform(-0.3, 1.2, (len(sets), len(widths))) * least
    dofs = rng.integers(0, 3, gains.shape)
    found = elements._best_of_families(sets, gains, dofs, most)
    assert found == in_numpy(lambda: elements._best_of_families(sets, gains, dofs, most))
    for chosen, own in zip(found, gains, strict=True):
        assert len(chosen) == min(most, len(set(family[own > 0])))
        assert len({family[k] for k in chosen}) == len(chosen) and all(own[k] > 0 for k in chosen)


@needs_library
@given(st.integers(1, 12), st.integers(1, 4), st.integers(0, 2**32 - 1))
@settings(max_examples=30)
def test_forward_selection_chooses_as_in_numpy(n_groups, width, seed):
    """The same groups of columns are added in the same order, whatever the least drop with which the selection goes on."""
    rng = np.random.default_rng(seed)
    gram, projection, _ = products(rng, n_groups * width + 1)
    projected = Projected(1.3, gram[:-1, :-1], projection[:-1], np.ones(len(gram) - 1))
    for least_drop in (0.0, 1.0, 8.0):
        chosen = projected.forward(width, least_drop)
        assert chosen == in_numpy(lambda drop=least_drop: projected.forward(width, drop))


@needs_library
@given(st.integers(0, 2**32 - 1))
@settings(max_examples=30)
def test_sets_that_share_elements_have_the_extensions_that_each_has_alone(seed):
    """What sets with common elements share does not depend on the order in which they are given, nor on the other sets."""
    rng = np.random.default_rng(seed)
    elements = elements_of(rng, rng.integers(1, 4, 9).tolist())
    sets = [tuple(sorted(rng.permutation(9)[: rng.integers(0, 6)].tolist())) for _ in range(12)]
    subsets = elements.subsets(sets)
    gains, dofs = elements._gains_given(subsets)
    for k, one in enumerate(subsets):
        others = [p not in one.elements for p in range(9)]
        alone = elements._gains_given([one])
        np.testing.assert_allclose(gains[k, others], alone[0][0, others], rtol=1e-5, atol=1e-7)
        np.testing.assert_array_equal(dofs[k, others], alone[1][0, others])


@needs_library
def test_matrices_that_have_lost_their_digits_are_left_to_numpy():
    """Where inner products with their priors, or correlations, are not positive definite, the library gives no numbers that are none."""
    gram, projection = np.diag([4.0, -3.0]), np.ones(2)
    elements = np.array([0, 1]), np.array([1, 1])
    assert set_gains(gram, projection, np.array([[1], [0]])) is None
    assert extension_gains(gram, projection, [np.array([1])], *elements) is None
    assert set_gains(gram, projection, np.array([[0]])) is not None
    assert extension_gains(gram, projection, [np.array([0])], *elements) is not None
    assert chosen_forward(gram, projection, 1, 0.1) == [0]
    bordering = np.array([[[1.0, 1.0, 1.0], [0.0, 1.0, 2.0], [1.0, 0.0, 1.0]]])
    assert restricted_likelihood(np.array([[0.5, 1.5, 0.5]]), bordering, 0.0) is None
    assert restricted_likelihood(np.array([[0.5, 0.2, 0.5]]), bordering, 0.0) is not None
