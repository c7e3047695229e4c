"""Writing and reading effects in the files of calibrations and diagnoses."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from scalar.effects import registry
from scalar.effects.effect import Effect


def effect_to_mapping(effect: Effect, std: Sequence[float | None]) -> dict[str, Any]:
    """Return an effect as calibrations and diagnoses write it; an effect from outside the package has its ``module`` as well.

    Args:
        effect: With its coefficients.
        std: ``(k,)``, standard errors of the coefficients; None for those that were not estimated.
    """
    module = registry.module_of(effect)
    return {
        "name": effect.name,
        **({} if module is None else {"module": module}),
        "target": effect.target,
        "coefficients": {
            name: {"value": float(value), "std": None if error is None else float(error)}
            for name, value, error in zip(effect.coefficient_names, effect.coefficients, std, strict=True)
        },
        "settings": effect.to_mapping(),
    }


def effect_from_mapping(mapping: Mapping[str, Any]) -> Effect:
    """Return the effect that ``effect_to_mapping`` wrote.

    Raises:
        InvalidInput: Its name is unknown, or the module that it came from is absent.
    """
    effect = registry.kind_named(mapping["name"], mapping.get("module")).from_mapping(mapping["settings"])
    values = [mapping["coefficients"][name]["value"] for name in effect.coefficient_names]
    return effect.with_coefficients(values)
