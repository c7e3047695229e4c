"""States that were fitted last are kept up to a size, and forgotten on request; what was dropped is fitted again."""

from types import SimpleNamespace

import numpy as np
import pytest

from scalar.diagnosis.fit import lately_fitted
from scalar.diagnosis.fit.lately_fitted import MOST_STATES, LatelyFitted

SMALL = 1000  # bytes of a state's candidate columns
LARGE = 90_000_000  # bytes of all that a state holds


class Fits:
    """Count the fits, each of which gives a state of one size."""

    def __init__(self, size: int) -> None:
        self.size, self.made = size, 0

    def __call__(self) -> SimpleNamespace:
        self.made += 1
        if self.size < LARGE:
            return SimpleNamespace(candidate_columns={0: np.empty(self.size, dtype=np.int8)})
        jacobian = np.empty(LARGE // 7, dtype=np.int8)
        return SimpleNamespace(
            candidate_columns={}, _linearised=(None, jacobian), held_bytes=lambda counted: self.size
        )


@pytest.fixture
def given_back(monkeypatch):
    """Return a list that grows by one whenever memory is given back to the system."""
    calls = []
    monkeypatch.setattr(lately_fitted, "give_back", lambda: calls.append(None))
    return calls


def test_a_known_state_is_not_fitted_again():
    """The same key gives the same object until it is forgotten."""
    kept, fits = LatelyFitted(), Fits(10)
    first = kept.of("a", fits)
    assert kept.of("a", fits) is first
    kept.forget()
    assert kept.of("a", fits) is not first
    assert fits.made == 2


def test_small_states_never_cost_a_call_to_the_system(given_back):
    """Hundreds of states of a small dataset are dropped without giving memory back."""
    kept, fits = LatelyFitted(), Fits(SMALL)
    for key in range(300):
        kept.of(key, fits)
    kept.forget()
    assert not given_back
    assert kept.of(299 - MOST_STATES, fits) and fits.made == 301


def test_large_states_are_dropped_and_given_back(given_back):
    """Of large states only the last few stay, and their memory goes back to the system as they are dropped, and when all are forgotten."""
    kept, fits = LatelyFitted(), Fits(LARGE)
    for key in range(4):
        kept.of(key, fits)
    assert len(given_back) == 1
    kept.of(3, fits)
    assert fits.made == 4
    kept.of(1, fits)
    assert fits.made == 5
    before = len(given_back)
    kept.forget()
    assert len(given_back) == before + 1
