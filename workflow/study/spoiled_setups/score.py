"""Score what is said of a spoiled set-up against what was made wrong."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from scalar.robots import arm_names
from study.spoiled_setups.spoilings import Truth

RIGHT, WRONG, REFUSED, DOUBTED, SILENT, CRASHED = OUTCOMES = (
    "named_right",
    "named_wrongly",
    "refused_unnamed",
    "accepted_doubted",
    "accepted_silent",
    "crashed",
)
"""What became of a set.

``named_right``: what was made wrong is named, alone or among readings that are said to be indistinguishable. ``named_wrongly``: another reading is
named, and not the right one. ``refused_unnamed``: there is no calibration, and no reading is named. ``accepted_doubted``: there is a calibration
with a doubt that names no reading. ``accepted_silent``: there is a calibration without a word.
"""
READINGS = {
    "joint_sign", "joint_zero", "convention", "swapped_joints", "angle_unit", "length_unit", "swapped_planes", "shifted_poses",
    "reversed_poses", "mirrored", "coupled_joints", "twist_sign", "length_sign", "length_digit", "sign_and_zero", "lost_row",
    "moved_target", "exchanged_target", "exchanged_columns", "other_arm", "joint_reading",
}  # fmt: skip
"""Values of ``Suspicion.what`` that say what is wrong; the others are doubts about where a fit ended."""


def outcome_of(truth: Truth, stage: str, said: Sequence[dict[str, Any]]) -> tuple[str, int]:
    """Return the outcome of a set, one of ``OUTCOMES``, and among how many suspicions the right one stands (0: it does not).

    Args:
        truth: What has to be named.
        stage: Where the program ended, as ``study.spoiled_setups.run.COLUMNS`` describes it.
        said: What it said: ``what``, ``where`` and ``sentence`` of each suspicion.
    """
    if stage == "crashed":
        return CRASHED, 0
    if any(names(truth, entry) for entry in said):
        return RIGHT, len(said)
    if stage != "accepted":
        return (WRONG if any(_is_reading(entry) for entry in said) else REFUSED), 0
    if any(_is_reading(entry) for entry in said):
        return WRONG, 0
    return (DOUBTED if said else SILENT), 0


def names(truth: Truth, entry: dict[str, Any]) -> bool:
    """Return whether a suspicion or a refusal says what was made wrong."""
    sentence = entry["sentence"]
    mentioned = {name for name in arm_names() if f"'{name}'" in sentence}
    if entry["what"] == "refusal":
        return _refusal_names(truth, sentence)
    if mentioned & set(truth.arms):
        return True
    if entry["what"] not in truth.whats or (truth.where and entry["where"] != truth.where):
        return False
    if truth.words and not any(word in sentence for word in truth.words):
        return False
    return not (truth.arms and mentioned)


def _refusal_names(truth: Truth, sentence: str) -> bool:
    """Return whether a refusal without readings, as that of a table whose numbers are implausible, asks for the right unit."""
    asked = "are these" in sentence
    return asked and "angle_unit" in truth.whats and any(word in sentence for word in truth.words)


def _is_reading(entry: dict[str, Any]) -> bool:
    """Return whether an entry states a cause."""
    return entry["what"] in READINGS or (entry["what"] == "refusal" and "are these" in entry["sentence"])
