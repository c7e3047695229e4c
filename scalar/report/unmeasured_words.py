"""The sentence of the report on errors where nothing was measured."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from scalar.report.words import number

_BY = "the angle of a joint, by place or by time"
_PLACES = {"x": "x", "y": "y", "z": "height z"}


def unmeasured_sentence(mapping: Mapping[str, Any]) -> str:
    """Return the sentence on errors where nothing was measured, or that the poses are too few to say.

    Args:
        mapping: The content of ``diagnosis.json``.
    """
    entry = mapping["unmeasured"]
    if entry is None:
        return "These poses are too few to say how far predictions err where nothing was measured."
    worst, rms = entry["worst_half"], entry["rms_mm"]
    begin = f"Where nothing was measured, expect up to {number(rms)} mm RMS"
    if rms > worst["rms_mm"]:
        limits = mapping["shipped"]["expected_error_mm"]["as_shipped_within_joint_limits"] or 0.0
        where = (
            "over the whole of the joint limits"
            if limits >= rms
            else "at poses like those that were measured"
        )
        return (
            f"{begin}, as {where}: when each of {entry['halves']} halves of the poses, by {_BY}, is predicted by the same model fitted to the other "
            f"half, the worst errs by no more than {number(worst['rms_mm'])} mm."
        )
    effects = mapping["shipped"]["fit"] != "before" and mapping["effects"]
    without = f" ({number(entry['without_effects_rms_mm'])} mm without effects)" if effects else ""
    return (
        f"{begin}{without}: each of {entry['halves']} halves of the poses, by {_BY}, was predicted by the same model fitted to the other half, and "
        f"the worst is {_half(worst)}{_by_chance(worst)}."
    )


def _by_chance(half: Mapping[str, Any]) -> str:
    """Return that the other half hardly determines the model, if most of the squared error is a chance error of the parameters; else nothing."""
    if half["chance_rms_mm"] ** 2 < 0.5 * half["rms_mm"] ** 2:
        return ""
    return ", most of whose error comes from the few poses: the other half hardly determines the model there"


def _half(half: Mapping[str, Any]) -> str:
    """Return which half of the poses it is."""
    along, upper = half["along"], half["upper"]
    if along == "order":
        return f"the {'later' if upper else 'earlier'} half"
    larger = "larger" if upper else "smaller"
    if along in _PLACES:
        return f"that with the {larger} {_PLACES[along]} of the flange"
    return f"that with the {larger} values of joint {along[1:]}"
