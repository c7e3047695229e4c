"""What an effect is called, how large its coefficients are, and how it is reported: its words and its pictures."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from scalar.effects.consequence import consequence_in_words
from scalar.effects.picture import Map, Profile, View, largest
from scalar.effects.title import titled
from scalar.effects.wording import coefficient, sized
from scalar.geometry.se3 import Array

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset

PRIOR_STD = {
    "rad": 3e-3,
    "m": 0.02,
    "rad/rad": 0.02,
    "m/m": 0.02,
    "1/m": 0.1,
    "1/K": 1e-3,
    "1": 1.0,
    "rad/(N m)": 1e-4,
}
"""Prior standard deviation of a coefficient by its unit: three to forty times the natural size of most effects. Unlisted units have no prior."""


@lru_cache
def _prior_stds(units: tuple[str, ...]) -> Array:
    """Return the prior standard deviations ``(k,)`` of coefficients with k units; read-only, since the same is asked for thousands of effects."""
    found = np.array([PRIOR_STD.get(unit, np.inf) for unit in units])
    found.setflags(write=False)
    return found


Table = tuple[tuple[str, ...], list[tuple[str, ...]]]
"""The head and the rows of a table of coefficients."""


@dataclass(frozen=True, eq=False)
class Described(ABC):
    """A set of coefficients that act at one place, with their units, sizes, words and pictures: the part of an effect that reports use.

    Attributes:
        coefficients: ``(k,)``, in the units of ``coefficient_units``.
    """

    coefficients: Array = field(default_factory=lambda: np.zeros(0), kw_only=True)

    name: ClassVar[str]  # in files and on the command line
    kind: ClassVar[str] = ""  # two or three words, for titles; the name where empty
    sentence: ClassVar[str]  # what it does, a clause without a full stop

    # How large it is.

    natural: ClassVar[Mapping[str, float]] = {}  # size of a coefficient in real workcells, by unit
    natural_source: ClassVar[str] = ""  # where these sizes come from
    # What a table of predicted poses contains because its rows state an order or a time, and which is no error of the arm; a clause.
    in_timed_predictions: ClassVar[str] = ""
    remedy: ClassVar[str] = ""  # what would make it observable, a clause
    remedy_advice: ClassVar[str] = ""  # the same as advice, whole sentences
    reported_with: ClassVar[str] = (
        ""  # kinds with the same text here are reported in one clause; if empty, the kind has its own
    )

    def __post_init__(self) -> None:
        if self.coefficients.size == 0:
            object.__setattr__(self, "coefficients", np.zeros(len(self.coefficient_names)))

    @property
    @abstractmethod
    def target(self) -> dict[str, Any]:
        """What the effect acts on, as ``diagnosis.json`` writes it."""

    @property
    @abstractmethod
    def coefficient_names(self) -> list[str]:
        """Names of the coefficients, their unit at the end."""

    @property
    @abstractmethod
    def coefficient_units(self) -> list[str]:
        """Units of the coefficients."""

    @property
    def prior_std(self) -> Array:
        """Return the prior standard deviation of every coefficient ``(k,)``.

        It is larger than the natural size, so that it hardly changes coefficients that the data determine; it keeps combinations of coefficients
        that the data hardly determine from growing without bound.
        """
        return _prior_stds(tuple(self.coefficient_units))

    def for_final_fit(self) -> Self:
        """Return the effect as it is fitted once it is known which effects there are: a flexible term may have a narrower prior then."""
        return self

    @property
    def plausible_std(self) -> Array:
        """Return the standard deviation ``(k,)`` by whose multiple a coefficient is judged implausible, infinite where any size is possible."""
        return self.prior_std

    @property
    def natural_sizes(self) -> Array:
        """Return the size that every coefficient has in real workcells ``(k,)``, zero where none is claimed."""
        return np.array([self.natural.get(unit, 0.0) for unit in self.coefficient_units])

    def stated(self, std: Sequence[float | None]) -> dict[str, tuple[float, float | None]]:
        """Return the numbers that a diagnosis states of the effect: by name, unit at the end, the value and its standard error.

        Args:
            std: ``(k,)``, standard errors of the coefficients, None where they were not estimated.
        """
        values = zip(self.coefficient_names, self.coefficients, std, strict=True)
        return {name: (float(value), error) for name, value, error in values}

    @property
    def depends_on(self) -> list[str]:
        """Return the columns of poses.csv that a flexible effect varies with."""
        return []

    # Words.

    @property
    def title(self) -> str:
        """Return what the effect is called in a report: its place, then its kind."""
        return titled(self.kind or self.name, self.target, self.depends_on)

    @property
    def clause(self) -> str:
        """Return what the effect does, as a clause of a sentence that names its place."""
        return self.title

    @classmethod
    def clause_of(cls, effects: Sequence[Self]) -> str:
        """Return what several effects of one kind do, as one clause."""
        return ", and ".join(dict.fromkeys(effect.clause for effect in effects))

    @property
    def sign_in_words(self) -> str:
        """Return what the sign of the coefficients means, a clause, if they are shown without it; empty where they are shown as they are."""
        return ""

    @property
    def described_as(self) -> str:
        """Return what a flexible term changes, a noun clause; empty for an effect with a name."""
        return ""

    def table(self, std: Sequence[float | None]) -> Table | None:
        """Return the coefficients as a table, with their standard errors ``(k,)``; None if they mean nothing to a reader."""
        sign = self.sign_in_words
        rows: list[tuple[str, ...]] = [
            coefficient(name, abs(value) if sign else value, error)
            for name, (value, error) in self.stated(std).items()
        ]
        if sign:
            rows[0] = (f"{rows[0][0]} ({sign})", *rows[0][1:])
        return ("coefficient", "value", "±", "unit"), rows

    def stiffness(self, std: Sequence[float | None]) -> list[tuple[int, float, float | None]]:
        """Return joint, stiffness and its standard error [N m/rad] of each joint whose compliance is known as such; none for most effects.

        If these data do not distinguish a joint from a rigid one, its stiffness is NaN, and in the place of the error stands the least stiffness
        that is compatible with them.
        """
        return []

    def consequence(self, error: float, which: int = 0) -> str:
        """Return a sentence on the error that the effect would cause if it were present, for data in which it is unobservable.

        Args:
            error: Error of predicted positions [m] if a coefficient of natural size is present and not in the model.
            which: Index of that coefficient.
        """
        size = sized(float(self.natural_sizes[which]), self.coefficient_units[which])
        return consequence_in_words(size, error, self.remedy)

    @property
    def advice(self) -> list[str]:
        """Return what to do about the effect if it was found, whole sentences; the first one is what to do first."""
        return []

    @property
    def how_to_measure(self) -> str:
        """Return how to measure the effect directly and separately from all others, a sentence; may be empty."""
        return ""

    @property
    def in_controller(self) -> str:
        """Return what changes in the robot's controller if the effect was found, a sentence; may be empty."""
        return ""

    @classmethod
    def advice_on_data(cls, dataset: Dataset) -> list[str]:
        """Return what to record so that effects of this kind could be looked for better, whole sentences."""
        return []

    # Pictures.

    def pictures(self, view: View) -> list[Profile | Map]:
        """Return partial residuals over what the effect depends on: at least one picture."""
        return [view.added_variable(self)]

    def size(self, pictures: Sequence[Profile | Map]) -> str:
        """Return how large the effect is at the poses that were measured, in words with its unit; may be empty."""
        return largest(pictures)
