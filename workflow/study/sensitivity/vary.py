"""Diagnose one blind set with the default settings, and with every variant of them whose answer could differ: a row for each variant."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import pandas as pd

from scalar.data.dataset import Dataset
from scalar.diagnosis import diagnose
from scalar.diagnosis.settings import DEFAULTS, Settings
from scalar.errors import ScalarError
from study.common.provenance import code_version
from study.sensitivity.answers import Answer, answer_of, differences, refusal
from study.sensitivity.traced import Trace
from study.sensitivity.traced_estimator import traced_estimator
from study.sensitivity.variants import Variant, traced_settings

ROW_COLUMNS = {
    "set": "name of the set in configs/sensitivity.yaml",
    "commit": "commit of the code that diagnosed; null outside a repository",
    "setting": "dotted name of a threshold",
    "direction": "halved or doubled",
    "value": "the changed value",
    "how": "unused: the setting entered no operation; same: every operation had the same result, so the answer is known; "
    "run: the set was diagnosed with the changed value",
    "changed": "kinds of statements that differ from those with the default settings, the gravest first, separated by ;",
    "example": "the gravest of them in words",
    "held_out_mm": "RMS error over held-out poses, as this diagnosis states it",
    "held_out_default_mm": "the same with the default settings",
    "unseen_mm": "mean position error over poses that are not in the set, base aligned",
    "unseen_default_mm": "the same with the default settings",
}
UNUSED, SAME, RUN = "unused", "same", "run"

AnswerTo = Callable[[Settings], Answer]
"""A function that returns the answer with given settings; it raises ``ScalarError`` if the diagnosis refuses the data."""


def answering(dataset: Dataset, truth_poses: pd.DataFrame) -> AnswerTo:
    """Return the function that diagnoses a dataset with given settings and returns the answer.

    Args:
        dataset: The dataset of one set.
        truth_poses: Poses that are not in the dataset, with their true frames.
    """
    return lambda settings: answer_of(diagnose(dataset, settings=settings), truth_poses)


def vary(name: str, answer_to: AnswerTo, wanted: Sequence[Variant]) -> pd.DataFrame:
    """Return a row for each variant, columns ``ROW_COLUMNS``.

    Args:
        name: Name of the set.
        answer_to: Returns the answer for the set with given settings.
        wanted: The variants to try.
    """

    def answer(settings: Settings) -> Answer:
        try:
            return answer_to(settings)
        except ScalarError as error:
            return refusal(error)

    commit = code_version()["commit"]
    default = answer(DEFAULTS)
    used, diverged = _traced(answer, default, wanted)
    rows = []
    for i, variant in enumerate(wanted):
        how = RUN if variant in diverged else SAME if variant in used else UNUSED
        other = _varied(answer, variant) if how == RUN else default
        found = differences(default, other)
        rows.append(
            {
                "set": name,
                "commit": commit,
                "setting": variant.setting,
                "direction": variant.direction,
                "value": variant.value,
                "how": how,
                "changed": ";".join(found),
                "example": next(iter(found.values()), ""),
                **{f"{key}_mm": other.get(f"{key}_mm") for key in ("held_out", "unseen")},
                **{f"{key}_default_mm": default.get(f"{key}_mm") for key in ("held_out", "unseen")},
            }
        )
        if how == RUN:
            print(
                f"{name} {i + 1}/{len(wanted)} {variant.setting} {variant.direction}: {';'.join(found) or 'same'}"
            )
    return pd.DataFrame(rows, columns=list(ROW_COLUMNS))


def _varied(answer: AnswerTo, variant: Variant) -> Answer:
    """Return a variant's answer; if the diagnosis ends in an error that is no refusal, the answer says so."""
    try:
        return answer(variant.settings)
    except Exception as error:  # a defect of this program: counted, and the other variants are still run
        return refusal(error)


def _traced(answer: AnswerTo, default: Answer, wanted: Sequence[Variant]) -> tuple[set[Any], set[Any]]:
    """Return the variants that enter any operation, and those whose answer could differ; all of them if tracing fails."""
    trace = Trace()
    try:
        with traced_estimator():
            same = not differences(default, answer(traced_settings(wanted, trace)))
    except Exception as error:  # something that a traced number cannot do
        print(f"tracing failed, so every variant is run: {type(error).__name__}: {error}")
        same = False
    if not same:
        return set(wanted), set(wanted)
    return trace.used, trace.diverged
