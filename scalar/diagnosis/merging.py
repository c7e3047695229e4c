"""Adding an effect to others, with which it may become one."""

from __future__ import annotations

from collections.abc import Sequence

from scalar.effects import Effect


def merged(effects: Sequence[Effect], new: Effect) -> tuple[Effect, ...]:
    """Return effects with a new one, which becomes one with an effect of which it has further terms."""
    result = list(effects)
    for i, old in enumerate(result):
        both = old.merged_with(new)
        if both is not None:
            result[i] = both
            return tuple(result)
    return (*result, new)
