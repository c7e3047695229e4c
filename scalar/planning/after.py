"""Whether further poses would answer the questions that a diagnosis left open; `scalar plan --after` and the report use the same judgement."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from scalar.data.dataset import Dataset
from scalar.estimation.misfit import excess_factor
from scalar.estimation.result import Calibration
from scalar.planning.candidates import Candidates
from scalar.planning.defaults import FURTHER_POSES
from scalar.planning.questions import Pair, open_questions
from scalar.planning.separation import ANSWERED, Answer, separating_poses
from scalar.planning.workcell import Workcell


@dataclass(frozen=True, eq=False)
class After:
    """The poses to add after a diagnosis, and how well they answer its open questions.

    Attributes:
        chosen: Indices of the candidates to add.
        pairs: The open questions: pairs of confounded effects, and effects that were unobservable.
        answers: For each of them, how well the measured poses and the added ones answer it.
        not_by_poses: The open questions that no further joint angles can answer, in words.
    """

    chosen: list[int]
    pairs: list[Pair]
    answers: list[Answer]
    not_by_poses: list[str]


def candidates_after(
    workcell: Workcell,
    draw: Callable[[bool], Candidates],
    dataset: Dataset,
    calibration: Calibration,
    left_open: tuple[list[Pair], list[str]],
    count: int = FURTHER_POSES,
) -> tuple[Candidates, After]:
    """Return candidates, and what ``poses_after`` chooses of them: within one turn of every joint, unless several turns answer more questions.

    Poses over several turns mean moves of a turn and more, and twisted cables; but some errors, such as a scale, grow from turn to turn.

    Args:
        workcell: The workcell near the calibration after the diagnosis.
        draw: Returns candidates, of which joints with wide limits stay within one turn if its argument is True.
        dataset: The dataset that was diagnosed.
        calibration: The calibration after the diagnosis.
        left_open: The open questions, as ``open_pairs`` returns them.
        count: How many poses.
    """
    within = draw(True)
    after = poses_after(workcell, within, dataset, calibration, left_open, count)
    nominal = workcell.model.nominal
    turns = np.ptp(np.delete(nominal.limits, list(nominal.prismatic), axis=0), axis=1)
    if all(answer.separated for answer in after.answers) or not np.any(turns > 2.0 * np.pi):
        return within, after
    wide = draw(False)
    wider = poses_after(workcell, wide, dataset, calibration, left_open, count)
    return (wide, wider) if _answered(wider) > _answered(after) else (within, after)


def _answered(after: After) -> tuple[int, int]:
    """Return how many questions the added poses answer, and how many all candidates would."""
    return sum(a.separated for a in after.answers), sum(a.separable for a in after.answers)


def poses_after(
    workcell: Workcell,
    found: Candidates,
    dataset: Dataset,
    calibration: Calibration,
    left_open: tuple[list[Pair], list[str]],
    count: int = FURTHER_POSES,
) -> After:
    """Return which candidates to add after a diagnosis, and how well they answer its open questions; none if poses can answer no question.

    Args:
        workcell: The workcell near the calibration after the diagnosis.
        found: The candidates.
        dataset: The dataset that was diagnosed.
        calibration: The calibration after the diagnosis.
        left_open: The open questions, as ``open_pairs`` returns them.
        count: How many poses.
    """
    pairs, not_by_poses = left_open
    if not pairs:
        return After([], [], [], not_by_poses)
    candidates = workcell.dataset(found.q, found.plane)
    what = open_questions(workcell, pairs, dataset, candidates, excess_factor(calibration.summary))
    chosen, answers = separating_poses(what.questions, what.start, what.rows, count)
    return After(chosen, pairs, answers, not_by_poses)


def outcome(answer: Answer) -> str:
    """Return in words how the signal that answers a question grows with the added poses, and whether they answer it."""
    sizes = f"{answer.now**0.5:.1f} -> {answer.planned**0.5:.1f} standard errors"
    if answer.separated:
        return f"{sizes}; separated"
    if round(answer.planned**0.5, 1) >= ANSWERED**0.5:
        sizes = f"{answer.now**0.5:.1f} -> just below {ANSWERED**0.5:g} standard errors"
    if answer.separable:
        return f"{sizes}; not yet separated: plan more poses"
    return f"{sizes}; no poses here separate it (all candidates together: {answer.limit**0.5:.1f})"
