"""Whether further poses would distinguish what a diagnosis could not, as `scalar plan --after` judges it."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from scalar.data.io.atomic import plain
from scalar.errors import InvalidInput
from scalar.planning.after import After, candidates_after, outcome
from scalar.planning.candidates import Candidates, draw_candidates
from scalar.planning.defaults import FURTHER_POSES, N_CANDIDATES, REPEATABILITY
from scalar.planning.questions import open_pairs
from scalar.planning.sensor_noise import with_noise
from scalar.planning.separation import ANSWERED, Answer
from scalar.planning.workcell import Workcell
from scalar.report.words import quoted

if TYPE_CHECKING:
    from scalar.diagnosis.naming.finding import Finding
    from scalar.diagnosis.result import Diagnosis


def answer_on(diagnosis: Diagnosis, finding: Finding) -> Answer | None:
    """Return how well further poses would separate a finding from the first effect with which it is confounded; None if poses cannot."""
    near = finding.confounded_with[0]
    after = _after(diagnosis)
    if after is None:
        return None
    for pair, answer in zip(after.pairs, after.answers, strict=True):
        same = pair.effect.name == finding.effect.name and pair.effect.target == finding.effect.target
        if same and pair.rival is not None and pair.rival.same_place(near):
            return answer
    return None


def in_words(diagnosis: Diagnosis, finding: Finding) -> str:
    """Return ``answer_on`` in words, or an empty text if it is None."""
    answer = answer_on(diagnosis, finding)
    if answer is None:
        return ""
    change = outcome(answer).replace("->", "→")
    rival = quoted(finding.confounded_with[0].title)
    if answer.now >= ANSWERED:
        return (
            f"The poses measured so far should distinguish it from {rival} already, by {answer.now**0.5:.1f} standard errors; the {FURTHER_POSES} "
            f"further poses that 'scalar plan FOLDER --after diagnosis.json' chooses would make this {answer.planned**0.5:.1f}."
        )
    return (
        f"With the {FURTHER_POSES} further poses that 'scalar plan FOLDER --after diagnosis.json' chooses (FOLDER is that of the dataset), "
        f"the signal that distinguishes it from {rival} changes: {change}. "
        f"At {ANSWERED**0.5:g} standard errors two causes count as separated."
    )


@lru_cache(maxsize=1)
def _after(diagnosis: Diagnosis) -> After | None:
    """Return how well further poses would answer the open questions; None if no candidate poses are found. Collisions are not tested."""
    dataset = diagnosis.dataset
    calibration = diagnosis.calibration_after
    sensor = with_noise(dataset.sensor, calibration)
    try:
        workcell = Workcell.of(
            dataset.robot,
            sensor,
            dataset.planes,
            calibration,
            repeatability=REPEATABILITY,
            same_campaign=True,
        )
        left_open = open_pairs(plain(diagnosis.to_mapping()), calibration.model.effects, dataset)

        def draw(one_turn: bool) -> Candidates:
            return draw_candidates(workcell, N_CANDIDATES, np.random.default_rng(0), one_turn=one_turn)

        return candidates_after(workcell, draw, dataset, calibration, left_open)[1]
    except InvalidInput:
        return None
