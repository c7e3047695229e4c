"""Two further runs, each on one half of the poses, where residuals of similar poses are correlated: what they confirm, and how they predict.

Held-out poses took part in the choice of the effects. That makes their errors too small by little where residuals are independent, because few
candidates then pass the tests by chance. Where the residuals of similar poses are still correlated with all effects in the model, the tests
count more samples than there are, chosen effects may fit what these poses have in common, and held-out poses that resemble those of the fit do
not show it.
The whole diagnosis is then run anew on one half of the blocks and judged on the other, and vice versa (twofold cross-validation around the
choice; Varma and Simon, BMC Bioinformatics 7, 2006). These runs have half of the poses. They decide against effects that predict the other half
worse, and the stated error is corrected for the number of poses as in ``outer_split``.

A cause that acts on the arm acts in both halves, which share no poses (complementary pairs: Shah and Samworth, Journal of the Royal Statistical
Society B 75, 2013). What only some poses have in common shows in one of them or in neither. The confidence in a name is therefore limited by the
number of halves that choose it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from scalar.data.dataset import Dataset
from scalar.diagnosis.explained import Explained
from scalar.diagnosis.finding import Finding
from scalar.diagnosis.fitted_state import FittedState
from scalar.diagnosis.hold_out import moving_joints
from scalar.diagnosis.outer_split import OuterSplit, Run, outer_split
from scalar.diagnosis.settings import Settings
from scalar.estimation.design_effect import design_effect

EQUATIONS_FOR_EFFECTS = 4.0  # for each parameter: chosen, 64 scans of an arm of six joints; with 60, half of the trials are wholly right


def two_halves(
    dataset: Dataset, found: Explained, run: Run, settings: Settings, cores: int | None
) -> OuterSplit | None:
    """Return the answers of the two halves of the poses, or None where they are not needed, or where a half has too few poses to show effects.

    Args:
        dataset: All that was measured, gross errors included.
        found: The run on all poses.
        run: Diagnoses a dataset; importable by its name.
        settings: Thresholds.
        cores: How many runs at once; None: as many as this process may use processors.
    """
    equations = float(found.before.residuals.measurement.equations.sum())
    enough = equations / 2 >= EQUATIONS_FOR_EFFECTS * int(found.before.free.sum())
    if not (found.after.effects and enough and residuals_are_correlated(found.after)):
        return None
    halves = outer_split(
        dataset, found.cleaned, run, settings, 2, lambda done, total: None, cores, moving_joints(found.before)
    )
    return halves if halves is not None and halves.answers else None


def residuals_are_correlated(state: FittedState) -> bool:
    """Return whether the residuals of similar poses are significantly correlated, so that poses are fewer samples than they are in number."""
    ratio = float(np.sqrt(state.background_within_scans().variance))
    least = state.settings.estimation.fit.misfit_p_value
    return ratio > 0 and design_effect(state.residuals, state.model, state.free, ratio, least) > 1.0


def limited_by_halves(
    found: Sequence[Finding], halves: OuterSplit | None, least_confidence: float
) -> tuple[Finding, ...]:
    """Return the findings with the confidence in each name limited by the halves that chose it; a flexible term has no name.

    Args:
        found: All findings.
        halves: As ``two_halves`` returns them.
        least_confidence: Below which a name is doubtful.
    """
    if halves is None:
        return tuple(found)
    limits = [
        1.0 if f.effect.flexible else most_confidence(halves.selected_in(f.effect), halves) for f in found
    ]
    return tuple(
        replace(f, confidence=min(f.confidence, limit), doubtful=f.doubtful or limit < least_confidence)
        for f, limit in zip(found, limits, strict=True)
    )


def most_confidence(share: float, halves: OuterSplit) -> float:
    """Return the largest confidence in a name that a share of the halves chose: no limit if all did, else Laplace's rule of succession.

    Of two halves, one gives 1/2 and none 1/4: the probability that a further one would choose it.

    Args:
        share: Of the runs.
        halves: As ``two_halves`` returns them.
    """
    runs = len(halves.answers)
    return 1.0 if share == 1.0 else (share * runs + 1.0) / (runs + 2.0)
