"""What an effect is: a regressor at a place, linear in a few coefficients, and all that the package says of it.

A class in this package is one kind of effect and holds everything about it: its columns, what is proposed for a dataset, how large it is in
real arms, whether it goes with the arm to another campaign, its words and its pictures. Everything else in the estimator asks these questions and
knows no kind by its name. To add a kind, subclass one of the places of ``scalar.effects.places``; only what has no default need be written.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from scalar.data.poses import Poses
from scalar.effects.picture import Map, Profile, View, largest
from scalar.effects.title import titled
from scalar.effects.wording import coefficient, length, sized
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
}
"""By unit: ten times and more what real arms and workcells have. A coefficient with a unit that is not listed is not bounded."""

LEAST_HARM = 1e-6  # m: below it a prediction error is not worth a word

Table = tuple[tuple[str, ...], list[tuple[str, ...]]]
"""The head and the rows of a table of coefficients."""


@dataclass(frozen=True, eq=False)
class Effect(ABC):
    """One effect with its coefficients.

    Attributes:
        coefficients: ``(k,)``, in the units of ``coefficient_units``.
    """

    coefficients: Array = field(default_factory=lambda: np.zeros(0), kw_only=True)

    name: ClassVar[str]  # in files and on the command line
    kind: ClassVar[str] = ""  # two or three words, for titles; the name where empty
    sentence: ClassVar[str]  # what it does, a clause without a full stop

    # How large it is.

    natural: ClassVar[
        Mapping[str, float]
    ] = {}  # by unit: the size of a coefficient in real workcells; empty: no claim
    natural_source: ClassVar[str] = ""  # where these sizes come from
    remedy: ClassVar[str] = ""  # what would make it observable, a clause
    remedy_advice: ClassVar[str] = ""  # the same as advice, whole sentences

    # What it depends on.

    flexible: ClassVar[bool] = False  # whether it describes without explaining: it has no name of its own
    frees: ClassVar[str] = ""  # a kind of geometric parameter that is fixed at its nominal value without it
    acts_by_joint_angles: ClassVar[bool] = (
        True  # whether poses alone, whenever taken, decide what it predicts
    )
    most_words: ClassVar[int] = 1  # that may follow the name on a command line

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

        It is far larger than any effect worth finding, so that it shrinks nothing that the data show; it keeps combinations of columns
        that the data hardly determine from growing without bound.
        """
        return np.array([PRIOR_STD.get(unit, np.inf) for unit in self.coefficient_units])

    @property
    def natural_sizes(self) -> Array:
        """Return the size that every coefficient has in real workcells ``(k,)``, zero where none is claimed."""
        return np.array([self.natural.get(unit, 0.0) for unit in self.coefficient_units])

    # Saving.

    @abstractmethod
    def to_mapping(self) -> dict[str, Any]:
        """Return what is needed to make the same effect again, besides its name and coefficients."""

    @classmethod
    @abstractmethod
    def from_mapping(cls, mapping: Mapping[str, Any]) -> Self:
        """Return the effect of ``to_mapping``, its coefficients zero."""

    @property
    def key(self) -> str:
        """Name and target as one word, for the names of parameters; of two effects with the same one in a model, the second is numbered."""
        parts: list[str] = []
        for value in self.target.values():
            if isinstance(value, dict):
                parts.append(f"{value['order']:g}")
            elif not isinstance(value, list):
                parts.append(f"{value}")
        return "_".join([self.name, *parts])

    def with_coefficients(self, coefficients: Sequence[float] | Array) -> Self:
        """Return the same effect with other coefficients ``(k,)``."""
        return replace(self, coefficients=np.array(coefficients, dtype=float))

    def stated(self, std: Sequence[float | None]) -> dict[str, tuple[float, float | None]]:
        """Return the numbers that a diagnosis states of the effect: by name, unit at the end, the value and its standard error.

        Args:
            std: ``(k,)``, standard errors of the coefficients, None where they were not estimated.
        """
        values = zip(self.coefficient_names, self.coefficients, std, strict=True)
        return {name: (float(value), error) for name, value, error in values}

    def relinearised(self) -> Self:
        """Return the effect with what is not linear in it moved to where its coefficients lead; itself where that changes nothing.

        A number that an effect is not linear in has a coefficient of its own, whose column is the derivative by it, and is found by a few fits.
        """
        return self

    # What is proposed for a dataset.

    @classmethod
    def candidates(cls, dataset: Dataset) -> list[Effect]:
        """Return the effects of this kind that a diagnosis of the dataset tries; of several terms where some of them may suffice."""
        return []

    @classmethod
    def changes(cls, dataset: Dataset) -> list[tuple[Effect, Array]]:
        """Return effects that may set in at any pose: each as it acts all the time, and the poses ``(N,)`` bool that it touches."""
        return []

    def beginning(self, order: float, time: float | None) -> Self:
        """Return the effect setting in at an order of acquisition and a time [s], its coefficients zero; for those of ``changes``."""
        raise NotImplementedError

    @classmethod
    def parsed(cls, dataset: Dataset, words: Sequence[str]) -> list[Effect]:
        """Return the effects that a command line asks for by this kind's name, the words that follow it being the target.

        Raises:
            ValueError: The words name nothing of this dataset; what they may be.
        """
        raise NotImplementedError

    def imitators(self, dataset: Dataset) -> list[Effect]:
        """Return flexible effects that might be mistaken for this one, besides those that are tried on every dataset."""
        return []

    def partial_imitators(self, dataset: Dataset) -> list[Effect]:
        """Return flexible effects of which a few together might be mistaken for this one."""
        return []

    # Terms, and what is the same.

    @property
    def n_terms(self) -> int:
        """Return of how many terms the effect consists, each with as many coefficients as the others."""
        return 1

    def with_terms(self, chosen: Sequence[int]) -> Effect:
        """Return the effect with some of its terms only, in their own order, its coefficients zero."""
        return self

    @property
    def term_names(self) -> list[str]:
        """Return names of the coefficients that stay the same whatever other terms the effect has."""
        return self.coefficient_names

    def merged_with(self, other: Effect) -> Effect | None:
        """Return one effect that is both, or None where they stay two; known coefficients are kept."""
        return None

    def taking_over(self, other: Effect) -> Self:
        """Return the effect with the coefficients of another where their terms are the same, zero elsewhere."""
        known = dict(zip(other.term_names, other.coefficients, strict=True))
        return self.with_coefficients([known.get(name, 0.0) for name in self.term_names])

    @property
    def label(self) -> str:
        """Return a text that is the same for effects that would be reported as the same."""
        return f"{self.name} {self.target}"

    def same_place(self, other: Effect) -> bool:
        """Return whether another effect is the same but for its terms or its moment."""
        return type(self) is type(other) and self.label == other.label

    def same_answer(self, other: Effect) -> bool:
        """Return whether another effect says the same but for details."""
        return self.same_place(other)

    def variations(self, scale: float) -> list[Self]:
        """Return the effect with what is not linear in it a little changed, in steps of ``scale`` of what a first look resolves."""
        return [self]

    def at_a_pose(self, dataset: Dataset, poses: Poses) -> Self:
        """Return the effect with its moments moved to poses of the dataset, after ``variations`` have moved them in between."""
        return self

    # What it depends on.

    @property
    def depends_on(self) -> list[str]:
        """Return the columns of poses.csv that a flexible effect varies with."""
        return []

    @property
    def erring_joint(self) -> int | None:
        """Return the one joint whose angle errs, from 1; None where it is no error of one joint's angle."""
        return None

    @property
    def own_curve(self) -> int | None:
        """Return the joint, from 1, whose angle errs as a function of itself alone; else None."""
        return None

    @property
    def is_change_in_time(self) -> bool:
        """Return whether the effect is a change in the course of the acquisition."""
        return False

    def not_transferable(self, dataset: Dataset) -> str | None:
        """Return why the effect, found in another campaign, does not hold for a dataset of the same arm; None where it does."""
        return None

    # Words.

    @property
    def title(self) -> str:
        """Return what the effect is called in a report: its place, then its kind."""
        return titled(self.kind or self.name, self.target, self.depends_on)

    @property
    def clause(self) -> str:
        """Return what the effect does, as a clause of a sentence that names its place."""
        return self.title

    def table(self, std: Sequence[float | None]) -> Table | None:
        """Return the coefficients as a table, with their standard errors ``(k,)``; None where they mean nothing to a reader."""
        rows: list[tuple[str, ...]] = [
            coefficient(name, value, error) for name, (value, error) in self.stated(std).items()
        ]
        return ("coefficient", "value", "±", "unit"), rows

    def consequence(self, error: float, which: int = 0) -> str:
        """Return what it costs not to know the effect where these data cannot show it.

        Args:
            error: Of predicted positions [m], with a coefficient of natural size present and not in the model.
            which: Which coefficient.
        """
        size = sized(float(self.natural_sizes[which]), self.coefficient_units[which])
        if error < LEAST_HARM:
            harm = f"move predicted positions by less than {length(LEAST_HARM)}"
        else:
            harm = f"put predicted positions off by about {length(error)}"
        text = f"an error of {size} would leave no residual and {harm}"
        return f"{text}; {self.remedy}" if self.remedy and error >= LEAST_HARM else text

    @property
    def advice(self) -> list[str]:
        """Return what to do about the effect where it was found, whole sentences."""
        return []

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
