"""Thresholds of what is reported and shipped: unobservable effects, doubtful names, the shipped fit, and the outer split."""

from __future__ import annotations

from dataclasses import dataclass

from scalar.estimation.settings import setting


@dataclass(frozen=True)
class ObservabilitySettings:
    """When an effect is reported as unobservable."""

    unobservable: float = setting(
        0.01, "of a column's length", "an effect is unobservable if the other parameters absorb all but a smaller share of each of its columns",
        "chosen: an effect of natural size, tenths of a millimetre, then leaves micrometres in the residual",
    )  # fmt: skip


@dataclass(frozen=True)
class NamingSettings:
    """When a finding is given a name."""

    least_confidence: float = setting(
        0.6, "of 1", "a finding with less confidence is not given its name and is reported as unattributed",
        "Bayes' decision rule if a wrong name costs half as much again as a missing one, which the report still lists among the likely causes",
    )  # fmt: skip


@dataclass(frozen=True)
class ShippedFitSettings:
    """Which fit is written to ``after.json``."""

    beyond_chance: float = setting(
        2.0, "standard errors", "the predictions of two fits differ significantly if their difference is larger than this",
        "the usual two; the poses are the independent samples",
    )  # fmt: skip
    clearly_smaller_std: float = setting(
        0.7, "of the standard error of a prediction", "the weights of a variance component are used only if the standard error with them is smaller "
        "than this share of that with equal weights",
        "one over the root of two, half the variance: both standard errors are estimated from few poses, and are uncertain by tens of percent",
    )  # fmt: skip
    clearly_larger_error: float = setting(
        1.05, "of the held-out error with equal weights", "if the predictions of the fits with the weights of a variance component and without "
        "differ by more than chance allows, and the held-out error with the weights is larger than this, the weights are not used",
        "chosen as for ``clearly_smaller_error``: a twentieth; a random error of the poses changes held-out errors by about a hundredth",
    )  # fmt: skip
    clearly_smaller_error: float = setting(
        0.95, "of the expected error of a prediction", "a model with other effects than those found is shipped only if its expected error is at most "
        "this share of that with all effects found",
        "chosen: for an improvement of less than a twentieth, what is reported should also be what is corrected",
    )  # fmt: skip
    worth_correcting: float = setting(
        0.7, "of the expected error without effects", "no effect is corrected if the correction leaves a larger share than this",
        "one over the root of two: what a correction removes is then at least as large as the error that it leaves",
    )  # fmt: skip
    worth_doubtful: float = setting(
        0.5, "of the expected error without them", "changes in time without a sure name are not corrected if the correction leaves a larger share, "
        "unless it leaves at most the square of this share of the error without any effects",
        "chosen stricter than ``worth_correcting``: in simulated trials, corrections expected to leave 0.4 to 0.9 made predictions worse in "
        "three of five sets",
    )  # fmt: skip
    worth_remainder: float = setting(
        0.2, "of the expected error without effects", "a map of the scanner's error with a further error of it, and no effect of the arm, are "
        "not corrected if the correction leaves a larger share than this, both within the joint limits and at the measured poses",
        "chosen between twelve simulated sets: corrections expected to leave 0.28 to 0.67 made predictions up to 1.28 times worse in five of six; "
        "those expected to leave at most 0.1 left 0.04 to 0.35 of the true errors",
    )  # fmt: skip
    worth_a_block: float = setting(
        0.5, "of the expected error without effects", "effects that are expected to leave at most this share are not left out for the loss at a "
        "single held-out block",
        "chosen as for ``worth_doubtful``: what a correction removes is then as large as what it leaves, and one block says little against it",
    )  # fmt: skip
    most_extrapolated: float = setting(
        2.0, "of the held-out error without effects", "nothing is corrected if predictions within the joint limits are expected to err more than "
        "this with the effects, unless those of the model without effects are about as uncertain",
        "chosen between measured arms: 16 and 8 for grids of two joints, on which effects made predictions elsewhere ten and three times worse; 0.7 "
        "for a UR10 whose effects predict another campaign",
    )  # fmt: skip
    least_equations: float = setting(
        2.6, "for each parameter of the geometry", "unmodelled structure is not corrected, unless a named effect is, with fewer measured equations",
        "on 32 simulated sets of 21 to 45 poses (1.2 to 2.3 equations) with such structure alone, flexible terms made predictions worse "
        "in six and better in seven; on 75 sets of 60 to 300 poses, in five and 44",
    )  # fmt: skip
    few_equations: float = setting(
        5.0, "for each parameter of the geometry", "with fewer measured equations, effects are corrected although none has a sure name only if their "
        "F statistic is large",
        "chosen between simulated sets of 60 and of 120 poses (3.2 to 3.9 and 6.5 to 7.7 equations), of which the former alone need the limit",
    )  # fmt: skip
    least_f_statistic: float = setting(
        32.0, "of 1", "with few equations, effects of which none has a sure name are corrected only if their F statistic is at least this",
        "on 25 simulated sets of 60 poses, corrections with a smaller F statistic made predictions worse in five and better by a fifth in two "
        "of nine, the others in none and 16 of 16",
    )  # fmt: skip


@dataclass(frozen=True)
class OuterSplitSettings:
    """Which findings are confirmed by the runs of the outer split."""

    least_selected: float = setting(
        0.5, "of the runs", "an effect that a smaller share of the runs selects is not confirmed, and is no finding",
        "one half, the smallest threshold that Meinshausen and Bühlmann (2010) consider",
    )  # fmt: skip
