"""The states that were fitted last, which several stages of a diagnosis ask for: a candidate that one stage refuses is tried again by the next.

A fit that starts elsewhere is made anew. Where the data hardly determine a model, fits end where their way along a curved valley becomes too slow,
and which effects are selected depends on it: with states of the same effects from other starts, one half of one of 85 sets had other effects.
"""

from __future__ import annotations

import gc
from collections.abc import Callable, Hashable, Sequence
from typing import Any, Generic, Protocol, TypeVar

from scalar.diagnosis.fit.freed_memory import give_back
from scalar.diagnosis.settings import Settings
from scalar.effects import Effect
from scalar.estimation.model import Model
from scalar.geometry.se3 import Array

MOST_STATES = 16
_MOST_BYTES = 64_000_000  # of all that the states have computed; of thousands of poses only the last is kept

_MOST_DROPPED = 64_000_000  # bytes of dropped states, after which their memory is given back to the system: of small states it never is


class _Kept(Protocol):
    """What is kept: a ``FittedState``, whose module imports this one."""

    @property
    def candidate_columns(self) -> dict[int, Any]: ...


_State = TypeVar("_State", bound=_Kept)


class LatelyFitted(Generic[_State]):
    """The last states of some rows that were asked for, with all that they have computed since."""

    def __init__(self) -> None:
        """Begin without any."""
        self._states: dict[Hashable, _State] = {}
        self._dropped = 0  # bytes

    def of(self, key: Hashable, fit: Callable[[], _State]) -> _State:
        """Return the state of a key; it is fitted if it is not among those that are kept.

        Args:
            key: All on which the fit depends (``key_of``).
            fit: Fits the state.
        """
        known = self._states.pop(key, None)
        state = self._states[key] = fit() if known is None else known
        total = 0
        for k, older in enumerate(reversed(list(self._states))):
            total += _size(self._states[older])
            if k and (k >= MOST_STATES or total > _MOST_BYTES):
                self._dropped += _size(self._states.pop(older))
        if self._dropped > _MOST_DROPPED:
            self._dropped = 0
            give_back()
        return state

    def forget(self) -> None:
        """Keep no state any longer; those that are asked for again are fitted anew, with the same result.

        Processes that are started for other poses would hold them until they end.
        """
        large = sum(_size(state) for state in self._states.values()) > _MOST_DROPPED / 2
        self._states.clear()
        if large:
            gc.collect()
            give_back()


def key_of(settings: Settings, geometry_free: Array, effects: Sequence[Effect], start: Model) -> Hashable:
    """Return all on which a fit of effects to some rows depends: the thresholds, the free geometry, from where it starts, and the effects."""
    given = (
        (type(each), str(each.to_mapping()), each.prior_std.tobytes(), each.coefficients.tobytes())
        for each in effects
    )
    return id(settings), geometry_free.tobytes(), start, *given


def _size(state: _Kept) -> int:
    """Return the size of the Jacobian and of the candidates' columns of a state as far as they are known [bytes]."""
    jacobian = vars(state)["_linearised"][1].nbytes if "_linearised" in vars(state) else 0
    return jacobian + sum(columns.nbytes for columns in state.candidate_columns.values())
