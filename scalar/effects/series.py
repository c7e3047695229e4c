"""Errors of one joint that are a series in its own angle; an effect has a few terms of the series, or all of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Self

import numpy as np

from scalar.effects.effect import Effect
from scalar.effects.places import SingleJointEffect
from scalar.geometry.se3 import Array


@dataclass(frozen=True, eq=False)
class Series(SingleJointEffect):
    """An error of one joint's angle as a series of numbered terms of two coefficients each.

    A dataset of few poses does not distinguish neighbouring terms; a diagnosis may then fit all terms at once, each with a prior of its own.

    Attributes:
        joint: From 1.
        orders: The numbers of the terms, from 1.
        term_std: [rad], prior standard deviation of each term's coefficients; empty for the usual one.
    """

    joint: int
    orders: tuple[int, ...]
    term_std: tuple[float, ...] = field(default=(), kw_only=True)

    every_order: ClassVar[tuple[int, ...]]  # all terms that a joint's error may have of this kind

    def with_term_std(self, std: Sequence[float]) -> Self:
        """Return the effect with other prior standard deviations of its terms [rad]."""
        return replace(self, term_std=tuple(float(s) for s in std))

    @property
    def target(self) -> dict[str, Any]:
        """The joint with its order, or orders."""
        if len(self.orders) == 1:
            return {"joint": self.joint, "order": self.orders[0]}
        return {"joint": self.joint, "orders": list(self.orders)}

    @property
    def prior_std(self) -> Array:
        """Return the prior standard deviations of ``term_std``, or the usual ones if it is empty."""
        return np.repeat(self.term_std, 2) if self.term_std else super().prior_std

    @property
    def plausible_std(self) -> Array:
        """Return the usual prior standard deviations: those of ``term_std`` may be scaled for rows that are weighted by too small a noise."""
        return super().prior_std

    @property
    def own_angle_joint(self) -> int | None:
        """The joint."""
        return self.joint

    @property
    def n_terms(self) -> int:
        """Return the number of orders."""
        return len(self.orders)

    def change_with_orders(self, q: Array) -> Array:
        """Return how the fitted error changes as its orders do ``(N, n)`` [rad] for each of its n orders; ``(N, 0)`` if they are whole by nature.

        Args:
            q: ``(N,)``, the joint's angle [rad].
        """
        return np.zeros((len(q), 0))

    def with_terms(self, chosen: Sequence[int]) -> Effect:
        """Return some of the orders only."""
        return type(self)(self.joint, tuple(self.orders[i] for i in sorted(chosen)))

    def merged_with(self, other: Effect) -> Effect | None:
        """Return the orders of both where they are of the same joint and kind."""
        if not isinstance(other, Series) or type(self) is not type(other) or self.joint != other.joint:
            return None
        return type(self)(self.joint, tuple(sorted({*self.orders, *other.orders}))).with_coefficients_of(self)

    def same_place(self, other: Effect) -> bool:
        """Return whether the other has the same order of the joint, or whether both have several orders of it."""
        if isinstance(other, Series) and min(len(self.orders), len(other.orders)) > 1:
            return type(self) is type(other) and self.joint == other.joint
        return super().same_place(other)

    def same_answer(self, other: Effect) -> bool:
        """Return whether the other shares an order of the joint."""
        if isinstance(other, Series) and self.joint == other.joint:
            return bool(set(self.orders) & set(other.orders))
        return self.same_place(other)

    def to_mapping(self) -> dict[str, Any]:
        """Return joint and orders, and the prior standard deviations where the terms have their own."""
        own = {"prior_std_rad": list(self.term_std)} if self.term_std else {}
        return {"joint": self.joint, "orders": list(self.orders), **own}
