"""Add an effect to a set of effects; it is merged with an effect of the set that has the same place, if there is one."""

from __future__ import annotations

from collections.abc import Sequence

from scalar.effects import Effect


def merged(effects: Sequence[Effect], new: Effect) -> tuple[Effect, ...]:
    """Return the effects with a new one added; if it consists of further terms of one of them, the two become one effect."""
    result = list(effects)
    for i, old in enumerate(result):
        both = old.merged_with(new)
        if both is not None:
            result[i] = both
            return tuple(result)
    return (*result, new)
