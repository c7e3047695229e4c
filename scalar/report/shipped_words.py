"""What the report says of the fit that is shipped: how it weighs the poses, and where that decides the answer."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scalar.diagnosis.shipped_fit import BY_COMPONENT
from scalar.report.words import length, listed, number
from scalar.units import MM

if TYPE_CHECKING:
    from scalar.diagnosis.result import Diagnosis


def shipped_sentences(diagnosis: Diagnosis) -> list[str]:
    """Return whole sentences on the fit in ``after.json``; none where there was nothing to choose."""
    return [*_without_effects(diagnosis), *_left_out(diagnosis), *_weights(diagnosis)]


def _left_out(diagnosis: Diagnosis) -> list[str]:
    choice = diagnosis.shipped.choice
    if not choice.left_out or diagnosis.shipped.without_effects:
        return []
    names = listed([effect.title for effect in choice.left_out])
    return [
        f"after.json does not correct for {names}. With that correction, predictions at other poses are expected to err by "
        f"{length(choice.error_with)}, without it by {length(choice.error_without)}: these data do not determine it well enough."
    ]


def _without_effects(diagnosis: Diagnosis) -> list[str]:
    shipped = diagnosis.shipped
    if not shipped.without_effects:
        return []
    if shipped.decided_by == "expected_error":
        with_all, without = length(shipped.choice.error_with), length(shipped.choice.error_without)
        return [
            f"after.json is the model without effects. With them, predictions at other poses are expected to err by {with_all}, "
            f"without them by {without}. The effects are findings only, and nothing is corrected for them."
        ]
    return [
        "after.json is the model without effects. With them, poses held out from the fit are predicted worse "
        f"({number(shipped.effects_held_out.rms / MM)} mm RMS, {number(shipped.held_out.rms / MM)} mm without), by more than chance makes. "
        "The effects are findings only, and nothing is corrected for them."
    ]


def _weights(diagnosis: Diagnosis) -> list[str]:
    shipped = diagnosis.shipped
    found = shipped.disagreement
    if found is None or shipped.without_effects:
        return []
    weighted = shipped.fit == BY_COMPONENT
    equal_rms, weighted_rms = (f"{number(rms / MM, 4)} mm RMS" for rms in found.held_out_rms)
    equal_std, weighted_std = (length(std) for std in found.predicted_std)
    if shipped.decided_by == "held_out":
        why = f"poses held out from the fit are then predicted {'better' if weighted else 'no worse'}"
        figures = f"{weighted_rms} with the weights, {equal_rms} without"
    else:
        why = f"the weights {'make' if weighted else 'would not make'} predictions elsewhere clearly surer, and held-out poses do not tell"
        figures = f"when single poses are left out, predictions vary by {weighted_std} with the weights, by {equal_std} without"
    used = "the weights that this noise gives the poses" if weighted else "equal weights for all poses"
    sentences = [f"after.json is fitted with {used}: {why} ({figures})."]
    if found.beyond_chance:
        sentences.append(
            f"Take care: the two fits disagree. Their predictions are {length(found.apart)} apart, where chance makes "
            f"{length(found.apart_std)}. One kind of noise, the same for all poses, does not explain that: some poses hold something that "
            "others do not. Look at the poses with the largest residuals before the correction is used."
        )
    return sentences
