"""One blind set, diagnosed with the default settings and with every variant that could come out otherwise: a row for each variant."""

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
    "set": "of configs/sensitivity.yaml",
    "commit": "of the code that diagnosed; null outside a repository",
    "setting": "dotted name of a threshold",
    "direction": "halved or doubled",
    "value": "the changed value",
    "how": "unused: it entered no operation; same: every operation came out the same, so the answer is known; "
    "run: diagnosed with it",
    "changed": "kinds of statements that differ from the default's answer, the gravest first, with ; between",
    "example": "the gravest of them in words",
    "held_out_mm": "rms over poses held out, as this diagnosis states it",
    "held_out_default_mm": "the same with the default settings",
    "unseen_mm": "mean position error over true poses, base aligned",
    "unseen_default_mm": "the same with the default settings",
}
UNUSED, SAME, RUN = "unused", "same", "run"

AnswerTo = Callable[[Settings], Answer]
"""From settings to an answer; a refusal is a ``ScalarError``."""


def answering(dataset: Dataset, truth_poses: pd.DataFrame) -> AnswerTo:
    """Return the function that gives the diagnosis' answer for a dataset with given settings.

    Args:
        dataset: One set.
        truth_poses: Poses that it does not hold, with their true frames.
    """
    return lambda settings: answer_of(diagnose(dataset, settings=settings), truth_poses)


def vary(name: str, answer_to: AnswerTo, wanted: Sequence[Variant]) -> pd.DataFrame:
    """Return a row for each variant, columns ``ROW_COLUMNS``.

    Args:
        name: Of the set.
        answer_to: Gives the diagnosis' answer for the set with given settings.
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
    """Return a variant's answer; where the diagnosis ends in an error that is no refusal, the answer says so."""
    try:
        return answer(variant.settings)
    except Exception as error:  # a defect of ours: counted, and one variant does not stop the others
        return refusal(error)


def _traced(answer: AnswerTo, default: Answer, wanted: Sequence[Variant]) -> tuple[set[Any], set[Any]]:
    """Return which variants enter any operation, and which could come out otherwise; all, where tracing fails."""
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
