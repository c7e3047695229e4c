"""The base class of all effects: a regressor that acts at one place of the workcell and is linear in a few coefficients.

A class in this package is one kind of effect and holds everything about it: its columns, the candidates for a dataset, its size in real arms,
whether it can be transferred to another campaign of the same arm, its words and its pictures. The rest of the estimator uses the methods below
and names no kind. To add a kind, subclass one of the places of ``scalar.effects.places``; only what has no default need be written.
"""

from __future__ import annotations

import json
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from scalar.data.poses import Poses, is_joint
from scalar.effects.consequence import unnoticed
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
"""Prior standard deviation of a coefficient by its unit: at least ten times the size in real arms and workcells. Unlisted units have no prior."""

GRAVITY = "gravity"
"""What a flexible effect is said to depend on where it varies with the direction of gravity."""

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

    natural: ClassVar[Mapping[str, float]] = {}  # size of a coefficient in real workcells, by unit
    natural_source: ClassVar[str] = ""  # where these sizes come from
    remedy: ClassVar[str] = ""  # what would make it observable, a clause
    remedy_advice: ClassVar[str] = ""  # the same as advice, whole sentences
    told_with: ClassVar[str] = ""  # the same for effects that share one clause; the name where empty

    # What it depends on.

    flexible: ClassVar[bool] = False  # whether it describes a residual without naming a cause
    frees: ClassVar[str] = ""  # a kind of geometric parameter that is fixed at its nominal value without it
    acts_on_arm: ClassVar[bool] = (
        False  # whether it is the arm's own, its pedestal included, and not the sensor's or the target's
    )
    acts_by_joint_angles: ClassVar[bool] = True  # whether nothing but joint angles decides its predictions
    most_words: ClassVar[int] = 1  # most words that may follow the name on a command line

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
        """Return name and target as one word, for the names of parameters; if two effects of a model share it, the second is numbered."""
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
        """Return the effect linearised anew at its present coefficients, or the effect itself if that changes nothing.

        A nonlinear parameter of an effect has a coefficient of its own, whose column is the derivative by that parameter. Its value
        is found by a few fits, each followed by this step.
        """
        return self

    # What is proposed for a dataset.

    @classmethod
    def candidates(cls, dataset: Dataset) -> list[Effect]:
        """Return the effects of this kind that a diagnosis of the dataset tries. It may keep only some terms of a candidate."""
        return []

    @classmethod
    def changes(cls, dataset: Dataset) -> list[tuple[Effect, Array]]:
        """Return the effects that may set in at any pose: each as if it acted all the time, and the poses ``(N,)`` bool on which it acts."""
        return []

    def beginning(self, order: float, time: float | None) -> Self:
        """Return the effect setting in at an order of acquisition and a time [s], its coefficients zero; for those of ``changes``."""
        raise NotImplementedError

    @classmethod
    def parsed(cls, dataset: Dataset, words: Sequence[str]) -> list[Effect]:
        """Return the effects that a command line asks for by the name of this kind and the words after it, which state the target.

        Raises:
            ValueError: The words name nothing of this dataset; the message says what they may be.
        """
        raise NotImplementedError

    @classmethod
    def measured(cls, dataset: Dataset) -> Effect | None:
        """Return the effect as the dataset itself shows it, measured beside the poses, with its coefficients; None where nothing shows it."""
        return None

    def imitators(self, dataset: Dataset) -> list[Effect]:
        """Return flexible effects that might be mistaken for this one, besides those that are tried on every dataset."""
        return []

    @classmethod
    def nuisances(cls, dataset: Dataset) -> list[Effect]:
        """Return the effects of this kind that any set-up has a little of, found or not: the correction of what was found is judged beside them."""
        return []

    def generalised(self, dataset: Dataset) -> Effect | None:
        """Return an effect of which this one is a special form, where a wrong form would move the geometry; else None."""
        return None

    def partial_imitators(self, dataset: Dataset) -> list[Effect]:
        """Return flexible effects of which a few together might be mistaken for this one."""
        return []

    # Terms, and comparison with other effects.

    @property
    def n_terms(self) -> int:
        """Return the number of terms of the effect; each has the same number of coefficients."""
        return 1

    def with_terms(self, chosen: Sequence[int]) -> Effect:
        """Return the effect with some of its terms only, in their own order, its coefficients zero."""
        return self

    def parts(self) -> list[list[int]]:
        """Return the terms of each part of its answer: of a joint or an order, where it has several; else all terms together."""
        found: dict[str, list[int]] = {}
        for k in range(self.n_terms):
            found.setdefault(json.dumps(self.with_terms([k]).target, sort_keys=True), []).append(k)
        return list(found.values())

    @property
    def term_names(self) -> list[str]:
        """Return names of the coefficients that stay the same whatever other terms the effect has."""
        return self.coefficient_names

    def merged_with(self, other: Effect) -> Effect | None:
        """Return one effect that acts as both do, with their coefficients, or None if they cannot be merged."""
        return None

    def taking_over(self, other: Effect) -> Self:
        """Return the effect with the coefficients of another where their terms are the same, zero elsewhere."""
        known = dict(zip(other.term_names, other.coefficients, strict=True))
        return self.with_coefficients([known.get(name, 0.0) for name in self.term_names])

    @property
    def label(self) -> str:
        """Return a text that two effects share if a report would not distinguish them."""
        return f"{self.name} {self.target}"

    def same_place(self, other: Effect) -> bool:
        """Return whether another effect is of the same kind and target; terms and moment may differ."""
        return type(self) is type(other) and self.label == other.label

    def same_answer(self, other: Effect) -> bool:
        """Return whether naming the other effect would be the same answer to a reader."""
        return self.same_place(other)

    def variations(self, scale: float) -> list[Self]:
        """Return the effect with its nonlinear parameters changed a little, in steps of ``scale`` times the spacing of the candidates."""
        return [self]

    def at_a_pose(self, dataset: Dataset, poses: Poses) -> Self:
        """Return the effect with its moments at poses of the dataset; ``variations`` may have moved them to between poses."""
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

    @property
    def stays_with_arm(self) -> bool:
        """Return whether the effect is expected in every campaign with the same arm, whatever its sensor, clock and surroundings are."""
        varies_with = {name for name in self.depends_on if not is_joint(name)}
        return self.acts_on_arm and not self.is_change_in_time and varies_with <= {GRAVITY}

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

    @classmethod
    def clause_of(cls, effects: Sequence[Effect]) -> str:
        """Return what several effects of one kind do, as one clause."""
        return ", and ".join(dict.fromkeys(effect.clause for effect in effects))

    def table(self, std: Sequence[float | None]) -> Table | None:
        """Return the coefficients as a table, with their standard errors ``(k,)``; None if they mean nothing to a reader."""
        rows: list[tuple[str, ...]] = [
            coefficient(name, value, error) for name, (value, error) in self.stated(std).items()
        ]
        return ("coefficient", "value", "±", "unit"), rows

    def consequence(self, error: float, which: int = 0) -> str:
        """Return the sentence on what the effect would cost if it were present, where these data cannot show it.

        Args:
            error: Of predicted positions [m], with a coefficient of natural size present and not in the model.
            which: Which coefficient.
        """
        size = sized(float(self.natural_sizes[which]), self.coefficient_units[which])
        return unnoticed(size, error, self.remedy)

    @property
    def advice(self) -> list[str]:
        """Return what to do about the effect if it was found, whole sentences; the first one is what to do first."""
        return []

    @property
    def how_to_measure(self) -> str:
        """Return how to see the effect directly, apart from all others, a sentence; may be empty."""
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
