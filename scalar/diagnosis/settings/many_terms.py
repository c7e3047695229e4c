"""Thresholds of models with many terms: flexible terms for unmodelled structure, and joints with all orders at once."""

from __future__ import annotations

from dataclasses import dataclass

from scalar.estimation.settings import setting


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
    most_imitated: int = setting(
        16, "coefficients", "of a named effect in whose place several shapes together are tried",
        "chosen: eight orders; more are a spectrum, and each attempt refits everything several times",
    )  # fmt: skip
    rounds_of_refinement: int = setting(
        4, "rounds", "in which shapes that replace a name are refined, each given the others",
        "chosen: orders of two waves converge in three",
    )  # fmt: skip
    minor: float = setting(
        0.1,
        "of the unmodelled structure",
        "a named effect that explains a smaller share of it is dropped",
        "chosen: it is as likely a part of that structure",
    )
    max_terms: int = setting(3, "terms", "of unmodelled structure", "chosen: more is no description")
    looked_at: int = setting(
        4,
        "terms",
        "tried, in the order of their evidence",
        "chosen: neighbours of the best follow it in the ranking",
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
        4,
        "effects",
        "looked for once all orders are in the model, and candidates tried for each",
        "chosen: one is the rule",
    )
    parts: int = setting(5, "parts", "of a joint's range, each held out in turn", "the usual five folds")
    rounds: int = setting(
        60, "rounds", "of the search for the prior standard deviations", "chosen: it ends by itself"
    )
    least_size: float = setting(
        1e-7,
        "rad",
        "prior standard deviation below which an order is left out",
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
