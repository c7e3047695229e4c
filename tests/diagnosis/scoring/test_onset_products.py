"""Inner products of columns that begin at different poses are those of the columns themselves."""

import numpy as np
import pytest

from scalar.diagnosis.scoring.onset_products import OnsetColumns


@pytest.mark.parametrize("seed", range(4))
def test_products_are_those_of_the_columns_from_their_beginnings_on(seed):
    """Of columns as they are, and of changes of several kinds that begin at any poses, some of them at the same pose."""
    rng = np.random.default_rng(seed)
    N, m, given = 23, int(rng.integers(1, 4)), 7
    columns = OnsetColumns(rng.normal(size=(N * m, given)), m)
    steady, source = rng.permutation(given)[:4], rng.integers(0, given, 11)
    onset = rng.integers(1, N, 11)
    E = np.column_stack([columns.given[:, steady], columns.given[:, source]])
    for k, first in enumerate(onset, start=len(steady)):
        E[: first * m, k] = 0.0
    np.testing.assert_allclose(columns.grams(steady, source, onset), E.T @ E, atol=1e-12)
    every_source, every_onset = np.r_[steady, source], np.r_[np.zeros(len(steady), dtype=int), onset]
    np.testing.assert_array_equal(columns.columns(every_source, every_onset), E)


def test_without_changes_they_are_those_of_the_columns_as_they_are():
    """No column need begin at a pose."""
    given = np.random.default_rng(1).normal(size=(12, 3))
    none = np.zeros(0, dtype=int)
    np.testing.assert_allclose(OnsetColumns(given, 2).grams(np.arange(3), none, none), given.T @ given)
