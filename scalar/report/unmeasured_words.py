"""The sentence of the report on errors where nothing was measured."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from scalar.report.lead_in import WHERE_UNMEASURED
from scalar.report.words import number

_MANY_TIMES = 30.0  # chosen: what a model lacks seldom makes predictions elsewhere worse by more
_PLACES = {"x": "x", "y": "y", "z": "height z"}


def unmeasured_sentence(mapping: Mapping[str, Any]) -> str:
    """Return the sentence on errors where nothing was measured, or that the poses are too few to say.

    Args:
        mapping: The content of ``diagnosis.json``.
    """
    entry = mapping["unmeasured"]
    if entry is None:
        return "These poses are too few to say how far predictions err where nothing was measured."
    worst = entry["worst_half"]
    effects = mapping["shipped"]["fit"] != "before" and mapping["effects"]
    without = (
        f" (without effects the worst by {number(entry['without_effects_rms_mm'])} mm)" if effects else ""
    )
    too_large = _by_chance(worst) or _undetermined(mapping)
    return (
        f"{WHERE_UNMEASURED}, expect up to {number(entry['rms_mm'])} mm RMS{_as_elsewhere(mapping)}. Each of {entry['halves']} halves of the "
        "poses, by the angle of a joint, by place or by time, was predicted by the same model fitted to the other half: the median errs by "
        f"{number(entry['median_rms_mm'])} mm, and the worst, {_half(worst)}, by {number(worst['rms_mm'])} mm{without}{too_large}."
    )


def _as_elsewhere(mapping: Mapping[str, Any]) -> str:
    """Return which other stated error is larger than that of the worst half; nothing if none is."""
    rms = mapping["unmeasured"]["rms_mm"]
    if rms <= mapping["unmeasured"]["worst_half"]["rms_mm"]:
        return ""
    limits = mapping["shipped"]["expected_error_mm"]["as_shipped_within_joint_limits"] or 0.0
    return f", as {'over the whole of the joint limits' if limits >= rms else 'at poses like those that were measured'}"


def _by_chance(half: Mapping[str, Any]) -> str:
    """Return that the other half hardly determines the model, if most of the squared error is a chance error of the parameters; else nothing."""
    if half["chance_rms_mm"] ** 2 < 0.5 * half["rms_mm"] ** 2:
        return ""
    return "; the other half hardly determines the model there, so this may be far too large"


def _undetermined(mapping: Mapping[str, Any]) -> str:
    """Return that no half determines the model, if most halves err by many times what held-out poses do; else nothing."""
    held_out = mapping["residual"]["after"]["held_out_rms_mm"]
    if held_out is None or mapping["unmeasured"]["median_rms_mm"] < _MANY_TIMES * held_out:
        return ""
    return "; half of these poses do not determine the model, so this may be far too large"


def _half(half: Mapping[str, Any]) -> str:
    """Return which half of the poses it is."""
    along, upper = half["along"], half["upper"]
    if along == "order":
        return f"the {'later' if upper else 'earlier'} one"
    larger = "larger" if upper else "smaller"
    if along in _PLACES:
        return f"that with the {larger} {_PLACES[along]} of the flange"
    return f"that with the {larger} values of joint {along[1:]}"
