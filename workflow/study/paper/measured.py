"""Count, over the campaigns of measured arms, what the diagnosis says, and where its correction or the control predicts better."""

from __future__ import annotations

from collections.abc import Mapping
from math import isclose
from typing import Any

from study.blind_trials.stratified_score import WORSE

ARMS = {"motoman": ("motoman", "ma1440", "ma2010"), "iiwa": ("iiwa",)}
"""``{makers' arms: beginnings of the names of their sets}``."""


def measured_counts(sets: Mapping[str, Any]) -> dict[str, Any]:
    """Return in how many measured sets what holds: the verdicts, the errors on unseen poses without and with the correction, and the names.

    Args:
        sets: The sets of the summary of measured arms.

    Returns:
        ``sets``, ``unattributed`` (the verdict), ``named`` (with a name that is sure), and what ``_unseen`` returns for all of them;
        ``motoman``, the same for the Motomans; ``control_ahead``, the sets in which the control has the smallest error on held-out poses, by a
        factor of more than ``WORSE``; ``control_share``, the least and the greatest share of the gain on held-out poses that the control reaches
        too, over the sets of the iiwa; ``held_out_worse``, the sets in which the error on held-out poses is larger with the correction, by a
        factor of more than ``WORSE``.
    """
    shares = [share for found in _of(sets, "iiwa").values() if (share := _control_share(found)) is not None]
    return {
        "sets": len(sets),
        "unattributed": sum(found["verdict"] == "unattributed" for found in sets.values()),
        "named": sum(found.get("sure", 0) > 0 for found in sets.values()),
        **_unseen(sets),
        "motoman": _unseen(_of(sets, "motoman")),
        "control_ahead": [name for name, found in sets.items() if _control_ahead(found)],
        "held_out_worse": [name for name, found in sets.items() if _held_out_worse(found)],
        "control_share": {"least": min(shares, default=None), "greatest": max(shares, default=None)},
    }


def _of(sets: Mapping[str, Any], arms: str) -> dict[str, Any]:
    return {name: found for name, found in sets.items() if name.startswith(ARMS[arms])}


def _unseen(sets: Mapping[str, Any]) -> dict[str, int]:
    """Return how many sets have errors on unseen poses, and in how many of these the correction changes them, and how.

    Returns:
        ``unseen`` (with errors on unseen poses), and of these ``corrected`` (the error falls), ``clearly_corrected`` (by more than the standard
        deviation over the parts, without and with the correction), ``not_corrected`` (it stays: the geometry alone is shipped), ``harmful`` (it
        grows).
    """
    rows = [
        found["unseen"] for found in sets.values() if found.get("unseen", {}).get("before_rms_mm") is not None
    ]
    pairs = [(row["before_rms_mm"], row["after_rms_mm"]) for row in rows]
    scatter = [max(row["before_rms_spread_mm"], row["after_rms_spread_mm"]) for row in rows]
    return {
        "unseen": len(pairs),
        "corrected": sum(after < before and not isclose(before, after) for before, after in pairs),
        "clearly_corrected": sum(
            before - after > by for (before, after), by in zip(pairs, scatter, strict=True)
        ),
        "not_corrected": sum(isclose(before, after) for before, after in pairs),
        "harmful": sum(after > before and not isclose(before, after) for before, after in pairs),
    }


def _held_out(found: Mapping[str, Any]) -> tuple[float, float, float]:
    """Return the errors on held-out poses [mm] of the geometry, of the correction and of the control."""
    models = found["models"]
    return (
        models["geometry"]["held_out_rms_mm"],
        models["geometry_and_effects"]["held_out_rms_mm"],
        found["checks"]["shuffled"]["held_out_rms_mm"],
    )


def _control_ahead(found: Mapping[str, Any]) -> bool:
    geometry, corrected, control = _held_out(found)
    return WORSE * control < min(geometry, corrected)


def _held_out_worse(found: Mapping[str, Any]) -> bool:
    geometry, corrected, _ = _held_out(found)
    return corrected > WORSE * geometry


def _control_share(found: Mapping[str, Any]) -> float | None:
    """Return the share of the correction's gain that the control reaches too; None without a gain."""
    geometry, corrected, control = _held_out(found)
    return (geometry - control) / (geometry - corrected) if corrected < geometry else None
