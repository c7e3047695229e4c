"""The list of effects by name: what ``--effects`` frees, what the diagnosis tries, what a calibration file holds."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from scalar.effects.effect import Effect

CATALOGUE: dict[str, type[Effect]] = {}


def effect_to_mapping(effect: Effect, std: Mapping[str, float]) -> dict[str, Any]:
    """Return an effect as calibrations and diagnoses write it.

    Args:
        effect: With its coefficients.
        std: Standard errors by parameter name, for those that were estimated.
    """
    return {
        "name": effect.name,
        "target": effect.target,
        "coefficients": {
            name: {"value": float(value), "std": float(std[key]) if key in std else None}
            for name, key, value in zip(
                effect.coefficient_names, effect.parameter_names, effect.coefficients, strict=True
            )
        },
        "settings": effect.to_mapping(),
    }


def effect_from_mapping(mapping: Mapping[str, Any]) -> Effect:
    """Return the effect that ``effect_to_mapping`` wrote."""
    effect = CATALOGUE[mapping["name"]].from_mapping(mapping["settings"])
    values = [mapping["coefficients"][name]["value"] for name in effect.coefficient_names]
    return effect.with_coefficients(values)
