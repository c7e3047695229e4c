"""Thresholds of the selection of effects: its score test, its held-out poses, when an effect is added, and the search of whole sets."""

from __future__ import annotations

from dataclasses import dataclass

from scalar.estimation.settings import setting


@dataclass(frozen=True)
class ScoreTestSettings:
    """How the gain of a candidate is computed without a refit."""

    unobservable_share: float = setting(
        1e-5, "of a column's squared length", "a column of which the model cannot span a larger share than this is not scored",
        "chosen: rounding errors are far smaller, and the coefficient of such a column would need 1e5 times the data",
    )  # fmt: skip
    rank_tolerance: float = setting(
        1e-10,
        "of a column's length",
        "a column that the columns before it span to within a smaller share adds no direction",
        "rounding errors",
    )
    std_without_prior: float = setting(
        1e3,
        "standard errors",
        "prior standard deviation that a coefficient without a prior is given",
        "chosen: so wide that it shrinks nothing",
    )
    least_remainder: float = setting(
        0.2, "of the noise's variance", "the variance of the residual after any gain is taken to be at least this large",
        "chosen: so that no gain looks infinite where the data are nearly free of noise",
    )  # fmt: skip


@dataclass(frozen=True)
class HoldOutSettings:
    """How poses are held out, and when two held-out errors differ."""

    folds: int = setting(
        5, "folds", "number of folds of the poses; also the number of parts of a joint's range that are held out in turn, and of parts of the outer "
        "split",
        "the usual five",
    )  # fmt: skip
    blocks_per_fold: int = setting(
        4,
        "blocks",
        "number of blocks of successive poses in a fold",
        "chosen: twenty independent samples in all, each longer than the correlation of neighbours in time",
    )
    same_pose: float = setting(
        2e-3,
        "rad",
        "a pose that differs from another by less than this in every joint is a repetition of it",
        "chosen: a tenth of a degree, far above any repeatability",
    )
    least_derivative: float = setting(
        0.01, "of the largest derivative", "poses that differ only in joints with a smaller derivative of the measured values are the same pose",
        "chosen: the error of such a joint has a hundredth of the effect of another joint's; a tool on the last axis has a thousandth",
    )  # fmt: skip
    most_gain_of_block: float = setting(
        5.0, "of the median drop", "the gain of one block, in some comparisons its loss as well, counts for at most this multiple of the median "
        "change of a block",
        "chosen: a single block must not decide for an effect, nor hide one by its scatter",
    )  # fmt: skip
    most_of_pose: float = setting(
        100.0, "of the median squared error", "where gains of blocks are limited, the squared error of a pose counts for at most this multiple of "
        "the median before",
        "chosen: normal noise of one equation reaches 52 in one pose of a million; a pose of a stretched UR10 had 1,100",
    )  # fmt: skip
    tolerated_growth: float = setting(
        0.01, "of an error in metres", "an error that grows by no more than this share counts as about the same",
        "chosen: a few poses with long levers dominate a root mean square, and change it by as much by chance",
    )  # fmt: skip


@dataclass(frozen=True)
class SelectionSettings:
    """When an effect is added, replaced or dropped."""

    alpha_named_effect: float = setting(
        1e-3,
        "1",
        "probability of adding a named effect where there is none, corrected for all candidates that are tried",
        "the usual one in a thousand",
    )
    alpha_unnamed: float = setting(
        1e-5, "1", "probability of finding a flexible term (corrected for all that are tried) or a variance component where there is none",
        "chosen: a hundred times stricter than for a named effect, since either explains nearly any residual, and all effects are tested given it",
    )  # fmt: skip
    least_improvement: float = setting(
        2.0,
        "standard errors",
        "least drop of the squared held-out error with which an effect is added",
        "the usual two; the blocks are the independent samples",
    )
    swap_margin: float = setting(
        3.0,
        "nats",
        "another candidate replaces an effect only if its log evidence is larger by more than this",
        "odds of twenty",
    )
    overwhelming_evidence: float = setting(
        50.0, "nats", "a set of effects with this much more log evidence needs only not to be contradicted by the held-out poses; an error of "
        "the instrument replaces a name with it, although the scores before the refit hardly differ",
        "chosen: far more than a wrong model of the noise adds; held-out errors of few poses often do not fall clearly with the right effects",
    )  # fmt: skip
    same_load_margin: float = setting(
        7.0, "nats", "a second effect of the same load (the arm's weight bends joints and base) needs more log evidence than this",
        "odds of 1,000 to 1: a second such effect also explains what is left because the first is not modelled exactly. In simulated trials "
        "of up to 60 poses, none of 8 such second effects was right",
    )  # fmt: skip
    confounded_margin: float = setting(
        5.0,
        "nats",
        "effects whose log evidence differs by less than this are confounded",
        "odds of 150: the true effect should be among those that are listed as confounded",
    )
    max_effects: int = setting(
        60, "steps", "the selection ends after this many steps",
        "chosen: harmonics of several joints take many steps; the selection usually ends by itself",
    )  # fmt: skip
    change_margin: int = setting(
        4,
        "poses",
        "least number of poses before a change, and after its beginning; not fewer than the change has coefficients",
        "a plane that moves has three coefficients, and each scan of it shows two; with six in place of four, a knock after "
        "five scans of a plane was missed in 60 poses",
    )
    refinement_rounds: int = setting(
        3, "rounds", "nonlinear parameters are refined at most this often with steps of each size; so are the shapes that together replace a named "
        "effect, each given the others",
        "chosen: the second round seldom gains anything",
    )  # fmt: skip
    least_refinement: float = setting(
        0.05,
        "nats",
        "a refinement with a smaller gain of log evidence is the last",
        "chosen: far below any gain that decides something",
    )
    most_candidates_tried: int = setting(
        8,
        "candidates",
        "only this many candidates, those with the most evidence, are refitted to see whether held-out poses confirm them",
        "chosen: about as many candidates are confounded with one another",
    )
    rounding_variance: float = setting(
        1e-4,
        "of the noise's variance",
        "a residual with a smaller variance consists of rounding errors",
        "the square of a hundredth of the noise; its structure comes from the arithmetic",
    )
    plausible_coefficient: float = setting(
        10.0, "standard deviations", "an effect with a coefficient that is larger by this factor than Effect.plausible_std is implausible",
        "chosen: a coefficient far beyond the size in real arms can remove the residual by shrinking all data to a point",
    )  # fmt: skip
    max_cleanings: int = setting(
        3,
        "rounds",
        "cleaning given the effects, followed by a new selection, is repeated at most this often",
        "chosen: the second round seldom finds anything",
    )


@dataclass(frozen=True)
class SubsetSearchSettings:
    """How whole sets of effects are searched."""

    most_poses: int = setting(
        500,
        "poses",
        "sets of effects are searched with at most this many poses",
        "chosen: with more poses, every effect is significant alone",
    )
    stable_share: float = setting(
        0.6, "of the folds", "an element of the best set is kept if it is needed without each of at least this share of the folds, one left out at "
        "a time",
        "the usual threshold of stability selection",
    )  # fmt: skip
