"""The states that were fitted last, which several stages of a diagnosis ask for: a candidate that one stage refuses is tried again by the next.

A fit that starts elsewhere is made anew. Where the data hardly determine a model, fits end where their way along a curved valley becomes too slow,
and which effects are selected depends on it: with states of the same effects from other starts, one half of one of 85 sets had other effects.

The states that were asked for longest ago are dropped, by number or by memory. Of small datasets only the Jacobians and the candidates' columns are
counted, which takes no time; once the Jacobian is large, all arrays are (``held_arrays``). Dropped memory is given back to the system in large parts.
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
_MOST_BYTES = 64_000_000  # of the Jacobians and the candidates' columns of all states
_MOST_HELD = 192_000_000  # of all arrays of all states if they are large; of thousands of poses only the last state is kept
_LARGE = 1_000_000  # bytes of the largest Jacobian, from which on all arrays are counted: they take some seven times as much, or more

_MOST_DROPPED = 64_000_000  # bytes of dropped states, after which their memory is given back to the system: of small states it never is


class _Kept(Protocol):
    """What is kept: a ``FittedState``, whose module imports this one."""

    @property
    def candidate_columns(self) -> dict[int, Any]: ...

    def held_bytes(self, counted: set[int]) -> int: ...


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
        self._make_room(known)  # before the fit, which needs memory as well
        state = self._states[key] = fit() if known is None else known
        return state

    def _make_room(self, known: _State | None) -> None:
        """Drop the states that were asked for longest ago, so that another one may follow.

        Args:
            known: The one that follows, which is not among the others now; None if it has yet to be fitted.
        """
        older = list(reversed(self._states.items()))
        states = [state for _, state in older] if known is None else [known, *(state for _, state in older)]
        sizes, most = _sizes(states)
        total = 0 if known is None else sizes.pop(0)
        for k, ((key, _), size) in enumerate(zip(older, sizes, strict=True), 1):
            total += size
            if k >= MOST_STATES or total > most:
                del self._states[key]
                self._dropped += size
        del older, states
        if self._dropped > _MOST_DROPPED:
            self._dropped = 0
            give_back()

    def forget(self) -> None:
        """Keep no state any longer; those that are asked for again are fitted anew, with the same result.

        Processes that are started for other poses would hold them until they end. The states of a few hundred poses are left for the collector to
        find: to collect at once takes as long as several fits.
        """
        large = max(map(_jacobian_size, self._states.values()), default=0) > _LARGE
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


def _sizes(states: Sequence[_Kept]) -> tuple[list[int], int]:
    """Return the size of each of some states, and the size that all may have together [bytes]; what several of them hold counts for the first."""
    if max(map(_jacobian_size, states), default=0) < _LARGE:
        return [_size(state) for state in states], _MOST_BYTES
    counted: set[int] = set()
    return [state.held_bytes(counted) for state in states], _MOST_HELD


def _size(state: _Kept) -> int:
    """Return the size of the Jacobian and of the candidates' columns of a state as far as they are known [bytes]."""
    return _jacobian_size(state) + sum(columns.nbytes for columns in state.candidate_columns.values())


def _jacobian_size(state: _Kept) -> int:
    """Return the size of the Jacobian of a state, zero if it is not known yet [bytes]."""
    return vars(state)["_linearised"][1].nbytes if "_linearised" in vars(state) else 0
