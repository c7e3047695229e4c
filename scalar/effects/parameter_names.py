"""The names of the coefficients of a model's effects: no two are the same, whatever effects a model has together."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import count

from scalar.effects.effect import Effect

_REPEATED = "#"  # stands between key and number if effects earlier in the model have the same key


def parameter_names(effects: Sequence[Effect], taken: Iterable[str] = ()) -> list[tuple[str, ...]]:
    """Return for each effect the names of its coefficients, ``<key>.<coefficient>``.

    A key that an earlier effect has is numbered: ``thermal_drift``, ``thermal_drift#2``. The names therefore depend on the order of the
    effects, which files keep.

    Args:
        effects: In the model's order.
        taken: Names of the model's other parameters.

    Raises:
        ValueError: An effect has two coefficients of one name.
    """
    used = set(taken)
    result = []
    for effect in effects:
        coefficients = effect.coefficient_names
        if len(set(coefficients)) < len(coefficients):
            raise ValueError(
                f"two coefficients of {effect.name} have the same name: {', '.join(coefficients)}"
            )
        keys = (effect.key if n == 1 else f"{effect.key}{_REPEATED}{n}" for n in count(1))
        names = next(
            names for key in keys if used.isdisjoint(names := tuple(f"{key}.{name}" for name in coefficients))
        )
        used.update(names)
        result.append(names)
    return result


def effect_of(name: str) -> str:
    """Return the key of the effect whose coefficient a parameter of a model is, or the name itself for a parameter of the geometry."""
    key, dot, _ = name.rpartition(".")
    return key if dot else name
