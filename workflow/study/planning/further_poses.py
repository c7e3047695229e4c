"""Choose further poses from a pool that separate confounded causes, and as a control as many at random."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from scalar.data.dataset import Dataset
from scalar.diagnosis import Diagnosis
from scalar.estimation.misfit import excess_factor
from scalar.geometry.se3 import Array
from scalar.planning.questions import Pair, open_questions
from scalar.planning.separation import ANSWERED, Answer, noncentralities, separating_poses
from scalar.planning.workcell import View, Workcell
from study.planning.bound import best_noncentrality


@dataclass(frozen=True, eq=False)
class FurtherPoses:
    """Two choices of further poses from the pool of one set.

    Attributes:
        planned, random: Indices of the chosen poses in the simulated dataset.
        signals: The pairs of confounded causes, each with the cells of its row on the signal that distinguishes them [standard errors].
    """

    planned: Array
    random: Array
    signals: list[tuple[Pair, dict[str, Any]]]

    @classmethod
    def of(
        cls,
        every: Dataset,
        first: Array,
        diagnosis: Diagnosis,
        pairs: list[Pair],
        view: View,
        count: int,
        seed: Sequence[int],
    ) -> FurtherPoses:
        """Return both choices of poses.

        Args:
            every: All poses that were simulated.
            first: Indices of those that were diagnosed; the others are the pool.
            diagnosis: Their diagnosis.
            pairs: What it leaves open.
            view: What the scanner sees.
            count: Number of poses to choose.
            seed: Of the random choice.
        """
        calibration = diagnosis.calibration_after
        pool = np.setdiff1d(np.arange(every.n_poses), first)
        workcell = Workcell.of(every.robot, every.sensor, every.planes, calibration, view, same_campaign=True)
        candidates = workcell.dataset(every.q[pool], every.plane_index[pool])
        excess = excess_factor(calibration.summary)
        what = open_questions(workcell, pairs, diagnosis.dataset, candidates, excess)
        chosen, answers = separating_poses(what.questions, what.start, what.rows, count)
        drawn = np.random.default_rng(seed).choice(len(pool), count, replace=False)
        at_random = noncentralities(what.questions, what.start, what.rows[drawn])
        signals = [
            (
                pair,
                _signals(answer, random, best_noncentrality(answer.question, what.start, what.rows, count)),
            )
            for pair, answer, random in zip(pairs, answers, at_random, strict=True)
            if pair.rival is not None
        ]
        return cls(pool[chosen], pool[drawn], signals)


def _signals(answer: Answer, random: float, best: float) -> dict[str, Any]:
    """Return the cells of a row on the signal that distinguishes two causes, from noncentralities with random poses and of the bound."""
    return {
        "now": answer.now**0.5,
        "planned": answer.planned**0.5,
        "random": random**0.5,
        "best": best**0.5,
        "limit": answer.limit**0.5,
        "separable": best >= ANSWERED,
        "separable_by_all": answer.separable,
        "separated": answer.separated,
        "separated_at_random": random >= ANSWERED,
    }
