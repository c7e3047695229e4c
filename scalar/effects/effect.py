"""The base class of all effects: a regressor that acts at one place of the workcell and is linear in a few coefficients.

A class in this package is one kind of effect and holds everything about it: its columns, the candidates for a dataset, its size in real arms,
whether it can be transferred to another campaign of the same arm, its words and its pictures. The rest of the estimator uses the methods of
``Effect`` and of its base class ``Described``, and names no kind. To add a kind, subclass one of the places of ``scalar.effects.places``; only
methods without a default have to be written.
"""

from __future__ import annotations

import json
from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from scalar.data.poses import Poses, is_joint
from scalar.effects.described import PRIOR_STD as PRIOR_STD
from scalar.effects.described import Described
from scalar.effects.described import Table as Table
from scalar.geometry.se3 import Array

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset
    from scalar.geometry.robot import BoolArray, Robot

GRAVITY = "gravity"  # the name, in ``depends_on``, of the direction of gravity
WEIGHT = "weight"  # the load of effects by which something gives way under the weight of the arm


@dataclass(frozen=True, eq=False)
class Effect(Described):
    """One effect with its coefficients: the methods that the estimator uses. Those for units, words and pictures are in ``Described``."""

    flexible: ClassVar[bool] = False  # whether it describes a residual without naming a cause
    frees: ClassVar[str] = ""  # a kind of geometric parameter that is fixed unless the model has this effect
    acts_on_arm: ClassVar[bool] = False  # whether it is one of the arm or its pedestal
    of_instrument: ClassVar[bool] = False  # whether it is an error of the measuring instrument
    # Whether it stands for an error of any smooth form, of which something remains that looks like another effect.
    any_smooth_form: ClassVar[bool] = False
    growth_of_arm: ClassVar[bool] = False  # whether the whole arm grows in the course of time
    read_before_arrival: ClassVar[bool] = False  # whether it is what a joint still moves after it was read
    load: ClassVar[str] = ""  # under which something gives way; effects of one load imitate one another
    acts_by_joint_angles: ClassVar[bool] = True  # whether its predictions depend on joint angles alone
    # Whether every set-up has effects of this kind to a small degree (nuisances). They do not count as a choice among the candidates: a diagnosis
    # prefers them to an effect of the arm that explains little more, and the model that judges corrections contains all of them.
    in_every_setup: ClassVar[bool] = False
    # Whether the effects of ``imitators`` are as likely beforehand and as specific, so that none of their evidence is discounted.
    imitators_are_as_likely: ClassVar[bool] = False
    # Log odds [nats] that nearly all right names of this kind reach in simulated exams, and wrong ones seldom; infinitely small if no odds do so.
    usual_odds: ClassVar[float] = -np.inf
    borne_out_by_others: ClassVar[bool] = False  # whether another finding of this kind makes that irrelevant
    stretches_lengths: ClassVar[bool] = False  # whether it scales all lengths, which leaves no residual
    contains_imitated: ClassVar[bool] = False  # whether the effect that it imitates is a special case of it
    most_words: ClassVar[int] = 1  # most words that may follow the name on a command line

    # Saving.

    @abstractmethod
    def to_mapping(self) -> dict[str, Any]:
        """Return what is needed, besides the name and the coefficients, to restore the effect from a file."""

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

    def relinearised(self) -> Self:
        """Return the effect linearised anew at its present coefficients, or the same object if it has no nonlinear parameter to update.

        A nonlinear parameter of an effect (a time constant, say) has a coefficient of its own, whose column is the derivative by that
        parameter. Its value is found by a few fits, each followed by this step.
        """
        return self

    @property
    def command_words(self) -> list[str]:
        """Return the words that follow the target on a command line, as ``parsed`` reads them."""
        return []

    # What is proposed for a dataset.

    @classmethod
    def candidates(cls, dataset: Dataset) -> list[Effect]:
        """Return the candidates of this kind for a dataset. Selection may keep only some terms of a candidate."""
        return []

    @classmethod
    def changes(cls, dataset: Dataset) -> list[tuple[Effect, Array]]:
        """Return the changes of this kind, which may begin at any pose: the effect as if it acted all the time, and the poses on which it acts."""
        return []

    def beginning(self, order: float, time: float | None) -> Self:
        """Return the effect that begins at an order of acquisition and a time [s], its coefficients zero; only for effects of ``changes``."""
        raise NotImplementedError

    @classmethod
    def together(cls, dataset: Dataset) -> list[list[Effect]]:
        """Return groups of effects of this kind that one cause brings about together."""
        return []

    @classmethod
    def parsed(cls, dataset: Dataset, words: Sequence[str]) -> list[Effect]:
        """Return the effects that a command line asks for.

        Args:
            dataset: On which they act.
            words: After the name of this kind; they state the target.

        Raises:
            ValueError: The words name nothing of this dataset; the message says what they may be.
        """
        raise NotImplementedError

    @classmethod
    def measured(cls, dataset: Dataset) -> Effect | None:
        """Return the effect with the coefficients that the dataset itself measures, as by references on the base; None if it measures none."""
        return None

    def imitators(self, dataset: Dataset) -> list[Effect]:
        """Return flexible effects that might be mistaken for this one, besides those that are tried on every dataset."""
        return []

    @classmethod
    def in_every_arm(cls, dataset: Dataset) -> list[Effect]:
        """Return the effects of this kind that every arm has to some degree, whether or not the data show them.

        The band of the errors over the workspace allows for what the data leave open of them.
        """
        return []

    @classmethod
    def in_many_arms(cls, dataset: Dataset) -> list[Effect]:
        """Return the effects of this kind, each at one place, that many arms have; the errors over the workspace count each by its probability."""
        return cls.in_every_arm(dataset)

    def generalised(self, dataset: Dataset) -> Effect | None:
        """Return an effect of which this one is a special case, if the special case would bias the geometry when it holds only roughly; else None."""
        return None

    def partial_imitators(self, dataset: Dataset) -> list[Effect]:
        """Return flexible effects of which a few together might be mistaken for this one."""
        return []

    def alike_at_few_positions(self, dataset: Dataset) -> list[Effect]:
        """Return named effects that are not tried, because a joint takes few positions, although they may be the cause."""
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
        """Return the indices of the terms of each part of the effect: of each joint or order if it has several, else of all terms."""
        found: dict[str, list[int]] = {}
        for k in range(self.n_terms):
            found.setdefault(json.dumps(self.with_terms([k]).target, sort_keys=True), []).append(k)
        return list(found.values())

    @property
    def term_names(self) -> list[str]:
        """Return names of the coefficients that do not depend on which other terms the effect has."""
        return self.coefficient_names

    def merged_with(self, other: Effect) -> Effect | None:
        """Return one effect that acts as both do, with their coefficients, or None if they cannot be merged."""
        return None

    def with_coefficients_of(self, other: Effect) -> Self:
        """Return the effect with the coefficients of another where their terms are the same, zero elsewhere."""
        known = dict(zip(other.term_names, other.coefficients, strict=True))
        return self.with_coefficients([known.get(name, 0.0) for name in self.term_names])

    @property
    def label(self) -> str:
        """Return a text that two effects share if a report would not distinguish them."""
        return f"{self.name} {self.target}"

    def same_place(self, other: Effect) -> bool:
        """Return whether another effect is of the same kind and acts at the same place; terms and beginnings may differ."""
        return type(self) is type(other) and self.label == other.label

    def same_answer(self, other: Effect) -> bool:
        """Return whether naming the other effect would be the same answer to a reader."""
        return self.same_place(other)

    def variations(self, scale: float) -> list[Self]:
        """Return the effect with its nonlinear parameters changed a little, in steps of ``scale`` times the spacing of the candidates."""
        return [self]

    def at_a_pose(self, dataset: Dataset, poses: Poses) -> Self:
        """Return the effect with its beginning at a pose of the dataset; ``variations`` may have moved it between two poses."""
        return self

    # What it depends on.

    @property
    def erring_joint(self) -> int | None:
        """Return the number of the joint, from 1, if the effect is an error of a single joint's angle; else None."""
        return None

    @property
    def follows(self) -> tuple[str, ...]:
        """Return the columns of poses.csv, other than those of the joints and of the order, with whose values the effect grows."""
        return ()

    @property
    def moves_from(self) -> tuple[str, ...]:
        """Return the columns that tell the moves on which the effect depends; one is enough, and predictions without any leave the effect out."""
        return ()

    def moves_unknown(self, poses: Poses) -> BoolArray:
        """Return at which poses ``(N,)`` bool the moves on which the effect depends are not known, so that it is left out there."""
        return np.zeros(len(poses), dtype=bool)

    @property
    def own_weight_joints(self) -> frozenset[int]:
        """Return the joints that give way under the weight of their own link alone, if the effect says nothing else; else none.

        About a horizontal axis this weight is a sinusoid of the joint's angle, as an eccentric gear is; and it seldom acts alone, because a joint
        also bears the links after its own.
        """
        return frozenset()

    @property
    def own_angle_joint(self) -> int | None:
        """Return the number of the joint, from 1, if the effect is an error of that joint's angle that depends on this angle alone; else None."""
        return None

    def against_its_load(self, robot: Robot, poses: Poses) -> bool:
        """Return whether its coefficients make something move against the load that moves it, as the cause that it names cannot."""
        return False

    def along_typical_weight(self, robot: Robot, poses: Poses) -> float | None:
        """Return how well what gives way follows the weight of typical masses, from -1 to 1 (``typical_weight``); None where that says nothing."""
        return None

    def is_impossible(self, robot: Robot, poses: Poses) -> bool:
        """Return whether the effect, with its coefficients, cannot be what it is called, so that a model must not contain it."""
        return False

    @property
    def is_change_in_time(self) -> bool:
        """Return whether the effect is a change in the course of the acquisition."""
        return False

    @property
    def follows_order(self) -> bool:
        """Return whether the effect is known only where the order is known in which the poses were measured."""
        return self.is_change_in_time or "order" in {*self.moves_from, *self.depends_on}

    @property
    def takes_time(self) -> bool:
        """Return whether a change that begins at some pose is complete only after some time, which was estimated as well."""
        return False

    def since(self, poses: Poses) -> Array | None:
        """Return at which poses ``(N,)`` bool a change has happened that then stays, on the arm or on the sensor; None for any other effect."""
        return None

    @property
    def needs_records(self) -> bool:
        """Return whether it needs a column of poses.csv that is known only when a pose is measured, such as a torque."""
        varies_with = {name for name in self.depends_on if not is_joint(name)}
        return self.flexible and not varies_with <= {GRAVITY, "order"}

    @property
    def stays_with_arm(self) -> bool:
        """Return whether the effect is expected in every campaign with the same arm, with any sensor, at any time and in any surroundings."""
        varies_with = {name for name in self.depends_on if not is_joint(name)}
        return self.acts_on_arm and not self.is_change_in_time and varies_with <= {GRAVITY}

    def not_transferable(self, dataset: Dataset) -> str | None:
        """Return why the effect, found in another campaign, does not apply to a dataset of the same arm; None if it applies."""
        return None
