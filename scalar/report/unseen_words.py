"""What the report says of poses that nothing has seen, and of effects that the runs without a part of the poses do not confirm."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from scalar.report.words import capital, number, title

if TYPE_CHECKING:
    from scalar.diagnosis.result import Diagnosis

QUICK = (
    "This is a quick answer: the errors are of poses held out from the fit, which the choice of effects has seen. Errors on poses that nothing "
    "has seen, and which findings they confirm, take five diagnoses more (scalar diagnose without --quick)."
)


def unseen_sentences(diagnosis: Diagnosis, mapping: Mapping[str, Any]) -> list[str]:
    """Return whole sentences on unseen poses; that they are not known, after a quick answer."""
    outer = diagnosis.outer
    if outer is None:
        return [QUICK]
    before, after = (mapping["residual"][when] for when in ("before", "after"))
    sentences = []
    if after["unseen_rms_mm"] is not None:
        sentences.append(
            f"On poses that neither cleaning nor choice nor fit has seen ({len(outer.answers)} runs, each without a part of the poses) the error is "
            f"{_with_spread(after)} mm RMS, without effects {_with_spread(before)} mm; the worst pose is off by {number(after['unseen_max_mm'])} mm. "
            "This is what to expect at poses like the measured ones."
        )
    if outer.failed:
        sentences.append(
            f"{len(outer.failed)} of {outer.folds} runs came to no end without their part of the poses, which is not counted: {outer.failed[0]}."
        )
    for entry in mapping["not_confirmed"]:
        name = capital(title(entry["name"], entry["target"], entry.get("depends_on", ())))
        sentences.append(
            f"Not confirmed: {name} was chosen in {share(entry, diagnosis)}. It is no finding, and after.json does not correct for it."
        )
    return sentences


def share(entry: Mapping[str, Any], diagnosis: Diagnosis) -> str:
    """Return in how many runs something was chosen; empty where there were none."""
    if entry["selected_in"] is None or diagnosis.outer is None:
        return ""
    runs = len(diagnosis.outer.answers)
    return f"{round(entry['selected_in'] * runs)} of {runs} runs without a part of the poses"


def _with_spread(errors: Mapping[str, Any]) -> str:
    spread = errors["unseen_rms_spread_mm"]
    text = number(errors["unseen_rms_mm"])
    return text if spread is None else f"{text} ± {number(spread, 2)}"
