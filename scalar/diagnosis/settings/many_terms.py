"""Thresholds of models with many terms: flexible terms for unmodelled structure, and joints with all orders at once."""

from __future__ import annotations

from dataclasses import dataclass

from scalar.estimation.settings import setting


@dataclass(frozen=True)
class FlexibleTermSettings:
    """When structure is described by flexible terms, because no named effect explains it."""

    replacement_margin: float = setting(
        7.0,
        "nats",
        "a flexible term replaces a named effect only if its log evidence is larger by more than this",
        "odds of a thousand, in favour of the named effect",
    )
    least_share_to_refine: float = setting(
        0.7, "of a name's evidence", "a flexible term whose log evidence, before its nonlinear parameters are refined, is a smaller share of that "
        "of the named effect is not tried in its place",
        "chosen: refinement seldom adds a third to the log evidence",
    )  # fmt: skip
    most_further_shapes: int = setting(
        2,
        "shapes",
        "this many further flexible terms of one joint may join the first to replace a named effect",
        "chosen: they suffice for two steps, or for a bump with its flanks",
    )
    most_coefficients_imitated: int = setting(
        16, "coefficients", "several flexible terms together are tried in place of a named effect only if it has no more coefficients than this",
        "chosen: those of eight orders; more are a spectrum, and each attempt refits everything several times",
    )  # fmt: skip
    minor_share: float = setting(
        0.1,
        "of the unmodelled structure",
        "a named effect that explains a smaller share of the squared residual is dropped",
        "chosen: it is as likely a part of that structure",
    )
    max_terms: int = setting(
        3,
        "terms",
        "unmodelled structure is described by at most this many flexible terms, and by as many more once unneeded effects are dropped",
        "chosen: more terms no longer describe the structure in words",
    )
    most_terms_tried: int = setting(
        4,
        "terms",
        "only this many flexible terms, those with the most evidence, are refined and tried",
        "chosen: the neighbours of the best term follow it in the ranking",
    )


@dataclass(frozen=True)
class SpectrumSettings:
    """When a joint has all orders at once."""

    many_orders: int = setting(
        4,
        "orders",
        "a joint of which at least this many orders are found one by one has all orders fitted at once",
        "chosen: an eccentric gear has one order, a strain wave gear two or three",
    )
    rows_per_column: float = setting(
        2.0,
        "numbers",
        "all orders are fitted only if at least this many numbers were measured for each coefficient",
        "chosen: with fewer, held-out errors do not show whether the correction is right",
    )
