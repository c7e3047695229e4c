"""Thresholds of the forward selection: its score test, its held-out poses, and when an effect is added."""

from __future__ import annotations

from dataclasses import dataclass

from scalar.estimation.settings import setting


@dataclass(frozen=True)
class ScoreTestSettings:
    """How a candidate's gain is judged without a refit."""

    unobservable_share: float = setting(
        1e-5, "of a column's squared length", "a column with less left, given the model, is not scored",
        "chosen: rounding is far below, and such a column would need 1e5 times the data",
    )  # fmt: skip
    independent: float = setting(
        1e-10,
        "of a column's length",
        "a column with less left, given those before it, adds no direction",
        "rounding",
    )
    unbounded: float = setting(
        1e3,
        "standard errors",
        "prior standard deviation of a coefficient that has none",
        "chosen: so wide that it shrinks nothing",
    )
    least_remainder: float = setting(
        0.2, "of the noise's variance", "least variance that a residual is taken to have after any gain",
        "chosen: so that no gain looks infinite where the data are nearly free of noise",
    )  # fmt: skip


@dataclass(frozen=True)
class HoldOutSettings:
    """How poses are held out, and when an error of poses held out has changed."""

    folds: int = setting(
        5, "folds", "that the poses are dealt out to; parts of a joint's range that are held out; parts of the outer split, each left out of a whole "
        "diagnosis", "the usual five"
    )  # fmt: skip
    blocks_per_fold: int = setting(
        4,
        "blocks",
        "of successive poses in a fold",
        "chosen: twenty independent samples in all, each longer than neighbours are correlated",
    )
    same_pose: float = setting(
        2e-3,
        "rad",
        "a pose nearer than this in every joint is another's repetition",
        "chosen: a tenth of a degree, far above any repeatability",
    )
    still: float = setting(
        0.01, "of the largest derivative", "a joint with a smaller derivative of what is measured by its angle makes no pose another one",
        "chosen: its own error is then a hundredth of that of another joint; a tool on the last axis has a thousandth",
    )  # fmt: skip
    most_gain: float = setting(
        5.0, "of the median drop", "that one block's gain counts for at most",
        "chosen: a single block must not carry an effect, nor hide one by its scatter",
    )  # fmt: skip
    tolerated_growth: float = setting(
        0.01, "of an error in metres", "by which it may grow and still be about the same",
        "chosen: a few poses with long levers decide a root mean square, and add that much by chance",
    )  # fmt: skip


@dataclass(frozen=True)
class SelectionSettings:
    """When an effect is taken, replaced or left out."""

    alpha_named_effect: float = setting(
        1e-3,
        "1",
        "chance of taking an effect where there is none, corrected for all that were tried",
        "the usual one in a thousand",
    )
    alpha_unnamed: float = setting(
        1e-5, "1", "chance of seeing unmodelled structure, corrected for all terms that were tried, or a variance component, where there is none",
        "chosen: a hundred times stricter than for a name, since either takes up nearly anything, and decides how every effect is tested",
    )  # fmt: skip
    least_improvement: float = setting(
        2.0,
        "standard errors",
        "by which the squared error of poses held out has to fall",
        "the usual two, blocks being the samples",
    )
    swap_margin: float = setting(
        3.0,
        "nats",
        "of evidence by which another effect has to explain better to take a place",
        "odds of twenty",
    )
    confounded_margin: float = setting(
        5.0,
        "nats",
        "within which two effects are confounded",
        "odds of 150: the truth should be among what is listed as confounded",
    )
    max_effects: int = setting(
        60, "steps", "of the selection", "chosen: harmonics of several joints take many; it ends by itself"
    )
    change_margin: int = setting(
        6, "poses", "least number on each side of a change", "a slip has six coefficients"
    )
    refinement_rounds: int = setting(
        3, "rounds", "of finer looks with steps of each size, and of refining shapes that replace a name, each given the others",
        "chosen: the second seldom gains",
    )  # fmt: skip
    least_refinement: float = setting(
        0.05,
        "nats",
        "gain of a finer look below which no further one follows",
        "chosen: far below what decides anything",
    )
    tried: int = setting(
        8,
        "candidates",
        "that are added, best first, to see whether poses held out confirm them",
        "chosen: the confounded ones of a place",
    )
    rounding: float = setting(
        1e-4,
        "of the noise's variance",
        "a residual below it is rounding",
        "a hundredth of the noise, squared: its structure is the computer's",
    )
    plausible_coefficient: float = setting(
        10.0, "prior standard deviations", "that a coefficient of an effect may have",
        "chosen: a hundred times the size in real arms explains the data by leaving nothing of them",
    )  # fmt: skip
    max_cleanings: int = setting(
        3,
        "rounds",
        "of selection and of setting aside what stands out given the effects",
        "chosen: the second seldom finds anything",
    )


@dataclass(frozen=True)
class SubsetSearchSettings:
    """How sets of effects are searched."""

    most_poses: int = setting(
        500,
        "poses",
        "with which sets are searched",
        "chosen: with more, every effect stands out alone",
    )
    stable: float = setting(
        0.6, "of the folds", "share of the folds, left out one at a time, without which an element still has to be needed",
        "the usual threshold of stability selection",
    )  # fmt: skip
