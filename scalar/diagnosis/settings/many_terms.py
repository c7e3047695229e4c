"""Thresholds of models with many terms: flexible terms for unmodelled structure, and joints with all orders at once."""

from __future__ import annotations

from dataclasses import dataclass

from scalar.estimation.settings import setting


@dataclass(frozen=True)
class FlexibleTermSettings:
    """When structure is described by flexible terms, because no named effect explains it."""

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
    minor: float = setting(
        0.1,
        "of the unmodelled structure",
        "a named effect that explains a smaller share of it is dropped",
        "chosen: it is as likely a part of that structure",
    )
    max_terms: int = setting(
        3, "terms", "at most, that describe unmodelled structure", "chosen: more is no description"
    )
    looked_at: int = setting(
        4,
        "terms",
        "tried, in the order of their evidence",
        "chosen: neighbours of the best follow it in the ranking",
    )


@dataclass(frozen=True)
class SpectrumSettings:
    """When a joint has all orders at once."""

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
