"""Two further runs, each on one half of the poses, if residuals of similar poses are correlated: what they confirm, and how well they predict.

Held-out poses took part in the selection of the effects. If residuals are independent, this makes held-out errors only a little too small, because
few candidates pass the tests by chance. If the residuals of similar poses are still correlated with all effects in the model, the tests count more
independent samples than there are. Selected effects may then fit an error that only similar poses have in common, and held-out poses that resemble
those of the fit do not reveal it.
The whole diagnosis is then run anew on one half of the blocks and tested on the other, and vice versa (twofold cross-validation around the
selection; Varma and Simon, BMC Bioinformatics 7, 2006). If effects predict the other half worse, they are not shipped. The stated error is corrected
for the smaller number of poses in these runs as in ``outer_split``.

A cause that acts on the arm acts in both halves, which share no poses (complementary pairs: Shah and Samworth, Journal of the Royal Statistical
Society B 75, 2013). An error that only some poses have in common appears in one half or in neither. The confidence in a name is therefore limited by
the number of halves that select it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from scalar.data.dataset import Dataset
from scalar.diagnosis.explained import Explained
from scalar.diagnosis.fit.fitted_state import FittedState
from scalar.diagnosis.held_out.outer_split import OuterSplit, outer_split
from scalar.diagnosis.held_out.repeated_runs import Run
from scalar.diagnosis.held_out.repetitions import distinct_equations, moving_joints
from scalar.diagnosis.naming.finding import Finding
from scalar.diagnosis.settings import Settings
from scalar.estimation.design_effect import design_effect

# Least number of equations in each half for each free parameter. Chosen: 64 scans of an arm of six joints (with 60, half of the trials fail).
EQUATIONS_FOR_EFFECTS = 4.0


def two_halves(
    dataset: Dataset, found: Explained, run: Run, settings: Settings, cores: int | None
) -> OuterSplit | None:
    """Return the answers of the two halves of the poses; None if they are not needed, if a half has too few poses, or if both runs fail.

    They are needed if effects were found and the residuals of similar poses are correlated.

    Args:
        dataset: All that was measured, gross errors included.
        found: The run on all poses.
        run: Diagnoses a dataset; a function that other processes can import by its name.
        settings: Thresholds.
        cores: Number of runs at once; None for as many as there are processors that this process may use.
    """
    enough = distinct_equations(found.before) / 2 >= EQUATIONS_FOR_EFFECTS * int(found.before.free.sum())
    if not (found.after.effects and enough and residuals_are_correlated(found.after)):
        return None
    halves = outer_split(
        dataset, found.cleaned, run, settings, 2, lambda done, total: None, cores, moving_joints(found.before)
    )
    return halves if halves is not None and halves.answers else None


def residuals_are_correlated(state: FittedState) -> bool:
    """Return whether the residuals of similar poses are significantly correlated, so that N poses are fewer than N independent samples."""
    ratio = float(np.sqrt(state.background_within_scans().variance))
    least = state.settings.estimation.fit.misfit_p_value
    return ratio > 0 and design_effect(state.residuals, state.model, state.free, ratio, least) > 1.0


def limited_by_halves(
    found: Sequence[Finding], halves: OuterSplit | None, least_confidence: float
) -> tuple[Finding, ...]:
    """Return the findings with the confidence in each name limited by the halves that selected it; flexible terms are unchanged.

    Args:
        found: All findings.
        halves: The answers that ``two_halves`` returns.
        least_confidence: A name with less confidence is doubtful.
    """
    if halves is None:
        return tuple(found)
    return tuple(
        f
        if f.effect.flexible
        else f.limited(
            confidence_by_halves(halves.selected_in(f.effect), halves),
            least_confidence,
            why_limited(halves.selected_in(f.effect)),
        )
        for f in found
    )


def why_limited(share: float) -> str:
    """Return why a name that a share of the halves selected is not sure, as a clause."""
    halves = "only one of two halves of the poses shows it" if share else "neither half of the poses shows it"
    return f"{halves} when it is diagnosed alone"


def confidence_by_halves(share: float, halves: OuterSplit) -> float:
    """Return the largest confidence in a name that a share of the halves selected: 1 if all did, else Laplace's rule of succession.

    The rule gives the probability that a further run would select it: 1/2 if one of two halves did, and 1/4 if none did.

    Args:
        share: Share of the runs that selected it.
        halves: The answers that ``two_halves`` returns.
    """
    runs = len(halves.answers)
    return 1.0 if share == 1.0 else (share * runs + 1.0) / (runs + 2.0)
