"""The thresholds of the diagnosis in one frozen object: each with its unit, its meaning, and its source or the reason for its size.

The thresholds of the estimator, gross errors among them, are a part of it. What belongs to one effect (where its candidates stand, how large
it usually is) is said in that effect's own file. Grids of what is tried are no thresholds: a finer one finds the same, more slowly.
``snakemake sensitivity`` halves and doubles every threshold and tabulates what changes.
"""

from __future__ import annotations

from dataclasses import dataclass

from scalar.estimation.settings import DEFAULTS as ESTIMATION_DEFAULTS
from scalar.estimation.settings import EstimationSettings, setting


@dataclass(frozen=True)
class RefitSettings:
    """When a refit during the selection has converged."""

    tolerance: float = setting(
        1e-9, "relative", "of cost and coordinates where the careful fit ends", "chosen: rounding"
    )
    max_steps: int = setting(
        10, "steps", "of Gauss-Newton before the careful fit takes over", "chosen: three are the rule"
    )
    sound: float = setting(
        1e-11,
        "of the largest eigenvalue",
        "normal equations with a smaller one have too few digits",
        "rounding, squared by the normal equations",
    )
    promised: float = setting(
        1e-8,
        "of the misfit's variance",
        "a step that promises a smaller drop is the last",
        "a ten thousandth of a standard deviation, squared",
    )


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
        0.2, "of the noise's variance", "that a residual is taken to keep after any gain",
        "chosen: so that no gain looks infinite where the data are nearly free of noise",
    )  # fmt: skip


@dataclass(frozen=True)
class HoldOutSettings:
    """How poses are held out, and when an error of poses held out has changed."""

    folds: int = setting(5, "folds", "that the poses are dealt out to", "the usual five")
    blocks_per_fold: int = setting(
        4,
        "blocks",
        "of successive poses in a fold",
        "chosen: twenty independent samples in all, each longer than neighbours are alike",
    )
    same_pose: float = setting(
        2e-3,
        "rad",
        "a pose nearer than this in every joint is another's repetition",
        "chosen: a tenth of a degree, far above any repeatability",
    )
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
        "odds of 150: what is listed as confounded should hold the truth",
    )
    max_effects: int = setting(
        60, "steps", "of the selection", "chosen: harmonics of several joints take many; it ends by itself"
    )
    change_margin: int = setting(
        6, "poses", "least number on each side of a change", "a slip has six coefficients"
    )
    refinement_rounds: int = setting(
        3, "rounds", "of finer looks with steps of each size", "chosen: the second seldom gains"
    )
    least_refinement: float = setting(
        0.05, "nats", "that a finer look has to gain for another", "chosen: far below what decides anything"
    )
    tried: int = setting(
        8,
        "candidates",
        "that are added, best first, to see whether poses held out bear them out",
        "chosen: the confounded ones of a place",
    )
    rounding: float = setting(
        1e-4,
        "of the noise's variance",
        "a residual below it is rounding",
        "a hundredth of the noise, squared: its structure is the computer's",
    )
    max_cleanings: int = setting(
        3,
        "rounds",
        "of selection and of setting aside what stands out given the effects",
        "chosen: the second seldom finds anything",
    )


@dataclass(frozen=True)
class FlexibleTermSettings:
    """When structure that no name explains is taken for such."""

    alpha_flexible_term: float = setting(
        1e-5, "1", "chance of seeing unmodelled structure where there is none, corrected for all terms that were tried",
        "chosen: a hundred times stricter than for a name, since a flexible term fits nearly anything",
    )  # fmt: skip
    better_than_a_name: float = setting(
        7.0,
        "nats",
        "by which a flexible term has to explain better to replace a name",
        "odds of a thousand, in favour of the name",
    )
    hopeless: float = setting(
        0.7,
        "of a name's evidence",
        "a term with less at a coarse look is not refined",
        "chosen: refinement seldom gains a third",
    )
    more_shapes: int = setting(
        2,
        "shapes",
        "of one joint that may together replace its name",
        "chosen: two steps, or a bump with its flank",
    )
    minor: float = setting(
        0.1,
        "of the unmodelled structure",
        "a name that explains less is not given",
        "chosen: it is as likely a part of that structure",
    )
    max_terms: int = setting(3, "terms", "without a name", "chosen: more is no description")
    looked_at: int = setting(
        4, "terms", "of the best that are tried", "chosen: neighbours of the best follow it in the ranking"
    )


@dataclass(frozen=True)
class SpectrumSettings:
    """When a joint has all orders at once, and how they are fitted."""

    many_orders: int = setting(
        4,
        "orders",
        "of one joint, found one by one, that make a spectrum of it",
        "chosen: an eccentric gear has one, a strain wave gear two or three",
    )
    rows_per_column: float = setting(
        2.0,
        "numbers",
        "measured for each coefficient, at least",
        "chosen: with fewer the hold-out says nothing",
    )
    most_more: int = setting(
        4, "effects", "looked for given all orders, and candidates tried for each", "chosen: one is the rule"
    )
    parts: int = setting(5, "parts", "of a joint's range, each held out in turn", "the usual five folds")
    rounds: int = setting(
        60, "rounds", "of the search for the prior standard deviations", "chosen: it ends by itself"
    )
    first_size: float = setting(
        3e-5, "rad", "where that search starts",
        "a tenth of a strain wave gear's positioning accuracy, 1 arcmin = 2.9e-4 rad (Harmonic Drive LLC, CSF/CSG catalogue, table 40)",
    )  # fmt: skip
    least_size: float = setting(
        1e-7,
        "rad",
        "prior standard deviation below which an order is not there",
        "chosen: 0.1 micrometres at a metre",
    )
    converged: float = setting(
        1e-3,
        "relative",
        "change of the prior standard deviations that ends the search",
        "chosen: far below what they are known to",
    )
    hardly_bounded: float = setting(
        1e-8,
        "of a unit column",
        "ridge on all else, since a part that is left out may take away all that is known of a parameter",
        "rounding",
    )


@dataclass(frozen=True)
class VarianceComponentSettings:
    """When poses vary by more than the noise of their points, and when that is no noise."""

    alpha_variance_component: float = setting(
        1e-5,
        "1",
        "chance of a variance component where there is none",
        "chosen: it decides how every effect is tested",
    )
    confounded_likelihood: float = setting(
        3.0, "nats", "of likelihood within which jitter and bias are confounded", "odds of twenty"
    )
    worst_repeatability: float = setting(
        4e-4, "rad", "of each joint; poses that repeat worse are no jitter, something acts on them",
        "four times the worst orientation repeatability of an ABB IRB 1600, 87 microradians; its position repeats to 37 micrometres "
        "(Slamani, Nubiola and Bonev, Industrial Robot 39, 2012)",
    )  # fmt: skip


@dataclass(frozen=True)
class AutocorrelationSettings:
    """When residuals of neighbouring poses are autocorrelated."""

    alpha_autocorrelation: float = setting(
        1e-4,
        "1",
        "chance of autocorrelation where there is none, corrected for all orders that were tried",
        "chosen: it takes a name away",
    )
    neighbours: int = setting(3, "poses", "nearest in two joint angles", "as many as the lags in an order")
    least_poses: int = setting(
        12, "poses", "of a plane, for neighbours to be near one another", "chosen: four times the neighbours"
    )


@dataclass(frozen=True)
class ConfidenceSettings:
    """How evidence becomes a confidence; both numbers are fitted to the answers of the blind trials."""

    most: float = setting(
        0.97,
        "1",
        "share of the answers that seemed sure which were right",
        "fitted: paper/summaries/blind_trials",
    )
    temperature: float = setting(
        4.5, "1", "that log odds are divided by", "fitted: paper/summaries/blind_trials"
    )


@dataclass(frozen=True)
class ObservabilitySettings:
    """When an effect is declared unobservable."""

    unobservable: float = setting(
        0.01, "of a column's length", "an effect with less left, given the model, leaves no residual",
        "chosen: an effect of usual size, tenths of a millimetre, then leaves micrometres",
    )  # fmt: skip


@dataclass(frozen=True)
class Settings:
    """All thresholds of a diagnosis.

    Attributes:
        estimation: Gross errors, sufficiency, identifiability, fits.
    """

    estimation: EstimationSettings = ESTIMATION_DEFAULTS
    refit: RefitSettings = RefitSettings()
    score_test: ScoreTestSettings = ScoreTestSettings()
    hold_out: HoldOutSettings = HoldOutSettings()
    selection: SelectionSettings = SelectionSettings()
    flexible_terms: FlexibleTermSettings = FlexibleTermSettings()
    spectrum: SpectrumSettings = SpectrumSettings()
    variance_components: VarianceComponentSettings = VarianceComponentSettings()
    autocorrelation: AutocorrelationSettings = AutocorrelationSettings()
    confidence: ConfidenceSettings = ConfidenceSettings()
    observability: ObservabilitySettings = ObservabilitySettings()


DEFAULTS = Settings()
