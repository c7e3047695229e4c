"""Thresholds for what is reported with the answers: unobservable effects, and which fit is shipped."""

from __future__ import annotations

from dataclasses import dataclass

from scalar.estimation.settings import setting


@dataclass(frozen=True)
class ObservabilitySettings:
    """When an effect is declared unobservable."""

    unobservable: float = setting(
        0.01, "of a column's length", "an effect with less left, given the model, leaves no residual",
        "chosen: an effect of usual size, tenths of a millimetre, then leaves micrometres",
    )  # fmt: skip


@dataclass(frozen=True)
class NamingSettings:
    """When what was found is given a name."""

    least_confidence: float = setting(
        0.5, "of 1", "a name with less confidence is not given, and what was found is unattributed",
        "Bayes' rule where a wrong name costs as much as a missing one: a name has to be likelier right than wrong",
    )  # fmt: skip


@dataclass(frozen=True)
class ShippedFitSettings:
    """Which fit becomes ``after.json``."""

    beyond_chance: float = setting(
        2.0, "standard errors", "by which the predictions of two fits have to differ to count as different",
        "the usual two, poses being the samples",
    )  # fmt: skip
    surer: float = setting(
        0.7, "of the standard error of a prediction", "that the weights of a variance component may leave at most, or equal weights are used",
        "one over the root of two, half the variance: both standard errors are estimated from few poses, and vary by tens of percent",
    )  # fmt: skip
    nearer: float = setting(
        0.95, "of the expected error of a prediction", "that a model with other effects than were found has to leave to be shipped instead",
        "chosen: what makes no difference of a twentieth is better corrected as it is reported",
    )  # fmt: skip
    worth_correcting: float = setting(
        0.7, "of the expected error without effects", "that a correction may leave at most, or nothing is corrected",
        "one over the root of two: what a correction removes is then at least as large as the error that it leaves",
    )  # fmt: skip


@dataclass(frozen=True)
class OuterSplitSettings:
    """How errors on poses that nothing has seen are found, and which findings these runs confirm."""

    least_selected: float = setting(
        0.5, "of the runs", "that have to choose an effect, or it is no finding",
        "one half, as proposed by Meinshausen and Bühlmann (2010) at the least",
    )  # fmt: skip
