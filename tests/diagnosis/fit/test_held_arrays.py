"""The memory that a fitted state holds is counted with all its arrays, each once, and limits how many states are kept."""

from types import SimpleNamespace

import numpy as np
import pytest

from scalar.diagnosis.fit import lately_fitted
from scalar.diagnosis.fit.column_products import ColumnBlock, ColumnProducts
from scalar.diagnosis.fit.fitted_state import refit
from scalar.diagnosis.fit.held_arrays import held_bytes
from scalar.diagnosis.fit.lately_fitted import LatelyFitted
from scalar.estimation.geometry_fit import geometry_fit
from tests.diagnosis.cases import scale


def test_an_array_and_its_views_count_once():
    """Views keep the whole array in memory, and two places that hold it share it."""
    array = np.zeros(1000)
    assert held_bytes({"whole": array, "part": [array[:10], array.reshape(10, 100)]}, set()) == 8000
    assert held_bytes((array[:1],), set()) == 8000


def test_objects_of_this_package_are_looked_into():
    """Arrays count wherever they are held below an object of the package, but not below one of another package."""
    rows = np.ones((2, 50))
    products = ColumnProducts([ColumnBlock(np.arange(2), rows, None)])
    others = sum(a.nbytes for a in (products.squared_lengths, products._place.base, np.arange(2)))
    assert held_bytes([products], set()) == rows.nbytes + others
    assert held_bytes([SimpleNamespace(rows=rows)], set()) == 0


def test_what_counts_already_is_not_counted_again():
    """The second of two states that share an array does not hold it."""
    shared, counted = np.zeros(100), set()
    first, second = [shared], [shared, np.zeros(1)]
    assert held_bytes(first, counted) == 800
    assert held_bytes(second, counted) == 8


@pytest.fixture(scope="module")
def state():
    """Return a fitted state that has computed its background."""
    dataset = scale(1, poses_per_plane=20)[0].dataset
    model, prepared = geometry_fit(dataset)
    state = refit(dataset, model, prepared.free, ())
    state.background()
    return state


def test_a_state_counts_what_it_computed_but_not_its_dataset(state):
    """The Jacobian and the basis of a state count; a dataset that all states share does not."""
    own = state.linearised()[1].nbytes + state.background().Q.nbytes
    held = state.held_bytes(set())
    assert held > own
    counted = set(map(id, (state.dataset, state.rows, state.settings, state.residuals.poses)))
    assert held_bytes(state, counted) == held
    assert held_bytes(state, set()) > held


def test_a_state_that_shares_its_arrays_holds_little(state):
    """A copy with other weights of the same state adds only what differs."""
    counted = set()
    first = state.held_bytes(counted)
    assert state.with_equal_weights().held_bytes(counted) < first / 10


def test_all_arrays_of_large_states_count(state, monkeypatch):
    """Once Jacobians are large, states are dropped by all that they hold; before, by Jacobians and columns alone."""
    size = state.linearised()[1].nbytes
    monkeypatch.setattr(lately_fitted, "_MOST_HELD", int(1.5 * state.held_bytes(set())))
    for large, n_kept in ((2 * size, 3), (size // 2, 2)):
        monkeypatch.setattr(lately_fitted, "_LARGE", large)
        kept, fits = LatelyFitted(), iter([fitted_anew(state) for _ in range(3)])
        for key in range(3):
            kept.of(key, lambda fits=fits: next(fits))
        assert len(kept._states) == n_kept


def fitted_anew(state):
    """Return the same state fitted anew, with its background."""
    found = refit(state.dataset, state.model, state.geometry_free, ())
    found.background()
    return found
