"""Sentences of the report on errors at unseen poses, and on effects that were found but are not confirmed.

Unseen poses took no part in the diagnosis that is judged by them: the whole diagnosis is run several times, each time without a part of the poses.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from scalar.effects.wording import with_error
from scalar.report.lead_in import NOT_CONFIRMED, ON_UNSEEN_POSES
from scalar.report.words import number, quoted, title

if TYPE_CHECKING:
    from scalar.diagnosis.result import Diagnosis

QUICK = (
    "This is a quick answer: the errors are those of poses that were held out from the fit but took part in the choice of effects, so they may be "
    "too small. Run 'scalar diagnose' without --quick for errors on unseen poses, and to see which findings they confirm."
)


QUICK_WITH_HALVES = (
    "This is a quick answer. Run 'scalar diagnose' without --quick for errors on unseen poses that are estimated with more of the poses, and to see "
    "which findings they confirm."
)


def unseen_sentences(diagnosis: Diagnosis, mapping: Mapping[str, Any]) -> list[str]:
    """Return sentences on the errors at unseen poses, or, after a quick answer, on how to get these."""
    outer = diagnosis.outer
    if outer is None:
        return [*_halves(mapping), QUICK if mapping["shipped"]["halves"] is None else QUICK_WITH_HALVES]
    before, after = (mapping["residual"][when] for when in ("before", "after"))
    sentences = _halves(mapping)
    if after["unseen_rms_mm"] is not None:
        alike = all(after[key] == before[key] for key in after if key.startswith("unseen"))
        without = "" if alike else f", and {_with_spread(before)} mm without effects"
        sentences.append(
            f"{ON_UNSEEN_POSES} ({len(outer.answers)} runs, each without a part of the poses) the error is "
            f"{_with_spread(after)} mm RMS{without}; at most {number(after['unseen_max_mm'])} mm at a pose. "
            "Errors of this size are to be expected of measurements at poses like these; the noise of the measurement is included."
        )
    if outer.failed:
        sentences.append(
            f"{len(outer.failed)} of {outer.folds} runs failed without their part of the poses, and that part is not counted: {outer.failed[0]}."
        )
    if outer.without_place:
        poses = "One pose is" if outer.without_place == 1 else f"{outer.without_place} poses are"
        target = diagnosis.after.residuals.measurement.target_words
        sentences.append(
            f"{poses} not counted, because the poses of the other parts do not show where the {target} stood there."
        )
    corrected = mapping["shipped"]["unconfirmed"]
    for entry in mapping["not_confirmed"]:
        name = title(entry["name"], entry["target"], entry.get("depends_on", ()))
        is_corrected = {key: entry[key] for key in ("name", "target")} in corrected
        # If it does, ``shipped_words`` says so.
        rest = "" if is_corrected else ", and after.json does not correct for it"
        sentences.append(
            f"{NOT_CONFIRMED}: {quoted(name)} was chosen in {share(entry, diagnosis)}. It is not counted as a finding{rest}."
        )
    return sentences


def _halves(mapping: Mapping[str, Any]) -> list[str]:
    """Return sentences on the two runs of the diagnosis on one half of the poses each; none if these were not made."""
    halves = mapping["shipped"]["halves"]
    if halves is None:
        return []
    without, effects = (number(halves[f"{which}_effects_rms_mm"]) for which in ("without", "with"))
    return [
        "Errors of similar poses are still correlated with the effects in the model, so poses held out from the fit say too little. The whole "
        "diagnosis was "
        f"therefore run on each half of the poses: the other half is predicted to {effects} mm RMS with the effects found there, and to {without} mm "
        "without. The error stated for held-out poses is that of these runs where it is larger, corrected for the smaller number of poses. A name "
        "that only one of the halves shows has a confidence of at most 50 %, and one that neither shows of at most 25 %."
    ]


def share(entry: Mapping[str, Any], diagnosis: Diagnosis) -> str:
    """Return in words in how many runs an entry was chosen; empty if there were no runs."""
    if entry["selected_in"] is None or diagnosis.outer is None:
        return ""
    runs = len(diagnosis.outer.answers)
    return f"{round(entry['selected_in'] * runs)} of {runs} runs without a part of the poses"


def _with_spread(errors: Mapping[str, Any]) -> str:
    spread = errors["unseen_rms_spread_mm"]
    value, error = with_error(errors["unseen_rms_mm"], spread)
    return value if spread is None else f"{value} ± {error}"
