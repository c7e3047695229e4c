"""Periodic errors of a joint with more periods a turn than eccentric gears cause."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from scalar.effects.command_words import orders_named, turning_named
from scalar.effects.effect import Effect
from scalar.effects.joint_harmonic import MAX_ORDER, MAX_RIPPLE_ORDER, JointHarmonic
from scalar.effects.title import ORDERS_IN_SENTENCE
from scalar.effects.wording import periods

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset


@dataclass(frozen=True, eq=False)
class JointRipple(JointHarmonic):
    """A joint's angle errs periodically in itself in orders above 32. Teeth, motor poles and encoder lines make such errors; eccentric gears do not.

    A ripple is found when all orders of a joint are fitted at once; single orders are not tried.
    """

    name: ClassVar[str] = "joint_ripple"
    kind: ClassVar[str] = "ripple"
    reported_with: ClassVar[str] = JointHarmonic.name
    sentence: ClassVar[str] = (
        "the joint's angle errs periodically over its own turn, too finely for an eccentric gear: teeth, motor poles or encoder lines do that"
    )
    natural: ClassVar[Mapping[str, float]] = {"rad": 1e-4}
    natural_source: ClassVar[str] = "assumed, a third of the harmonics of a gear; no data sheet states it"
    most_words: ClassVar[int] = 1 + MAX_RIPPLE_ORDER - MAX_ORDER
    every_order: ClassVar[tuple[int, ...]] = tuple(range(MAX_ORDER + 1, MAX_RIPPLE_ORDER + 1))

    @classmethod
    def candidates(cls, dataset: Dataset) -> list[Effect]:
        """Return nothing, because a few hundred poses do not distinguish neighbouring orders as high as these."""
        return []

    @classmethod
    def parsed(cls, dataset: Dataset, words: Sequence[str]) -> list[Effect]:
        """Return the orders of a joint that are named."""
        wanted = orders_named(words[1:], MAX_ORDER + 1, MAX_RIPPLE_ORDER)
        if not wanted:
            raise ValueError("name the joint and its orders, as in joint_ripple:3:40:48")
        return [cls(j, wanted) for j in turning_named(dataset, words)]

    @property
    def clause(self) -> str:
        """Return which joint errs, and how many periods a turn has."""
        return f"joint {self.joint} errs periodically and finely, with {periods(self.orders, ORDERS_IN_SENTENCE)}"

    @property
    def advice(self) -> list[str]:
        """Return what to look at."""
        return [
            f"Have the motor, the encoder and the gear teeth of joint {self.joint} checked: an eccentric gear makes no periods as short as these."
        ]
