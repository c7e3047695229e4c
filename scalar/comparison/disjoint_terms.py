"""Effects that two calibrations hold in different sets of coefficients, compared by what they do to positions.

Which coefficients of an effect a diagnosis keeps depends on its poses: the sag of a joint may be the torque of one link in one calibration, and of
three links in the other. Single coefficients then mean different things, so none of them is compared, but the two deflections are. Both are
computed at random poses within the joint limits. What a motion of the base, a shift of the sensor and the geometry explain is removed from them,
since the two fits may have divided it differently between these and the effect.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from scalar.comparison.arm_parameters import ArmParameters, effect_terms, effects_of_the_arm
from scalar.comparison.beyond_chance import is_beyond_chance
from scalar.comparison.moved import Moved
from scalar.effects.effect import Effect
from scalar.estimation.displacement import position_std, projected_out
from scalar.estimation.model import Model
from scalar.geometry.se3 import Array
from scalar.units import MM

_NULL = 1e-7  # relative to the largest singular value of the geometry's columns: directions with a smaller one move nothing


@dataclass(frozen=True, eq=False)
class DisjointTerms:
    """An effect that both calibrations have, without a coefficient that means the same in both.

    A coefficient is the same in both if its term, and the effect's name, target and settings, agree.

    Attributes:
        name: Name of the effect.
        parameters: Names of its coefficients in both calibrations.
        apart: Difference of the two displacements, after the best fit of base, sensor and free geometry is removed.
        by_chance: The root mean square difference [m] that both covariances lead to expect if the arm did not change.
        alpha: Probability that the difference is called beyond chance if nothing changed.
    """

    name: str
    parameters: tuple[str, ...]
    apart: Moved
    by_chance: float
    alpha: float

    @property
    def beyond_chance(self) -> bool:
        """Return whether the difference is so large that chance alone makes it with a probability of at most ``alpha``."""
        return is_beyond_chance(self.apart.rms, self.by_chance, self.alpha)

    def to_mapping(self) -> dict[str, object]:
        """Return the entry of ``comparison.json``."""
        return {
            "name": self.name,
            "parameters": list(self.parameters),
            **self.apart.to_mapping(),
            "by_chance_rms_mm": self.by_chance / MM,
            "beyond_chance": self.beyond_chance,
        }


def effects_with_disjoint_terms(
    a: Model, b: Model, arm: ArmParameters, columns: Array, alpha: float
) -> list[DisjointTerms]:
    """Return the effects that A and B both have without a common coefficient, and how far they move positions apart.

    Args:
        a: The model of the first calibration.
        b: The model of the second calibration.
        arm: The P parameters of the arm in both.
        columns: ``(3 K, P)``, derivatives of the positions at K random poses by these, as ``displacement_columns`` returns them.
        alpha: Probability that a difference is called beyond chance if nothing changed.
    """
    terms = [effect_terms(model) for model in (a, b)]
    groups: dict[str, list[Effect]] = {}
    for effect in effects_of_the_arm(arm.model):
        groups.setdefault(effect.label, []).append(effect)
    places = {column: i for i, column in enumerate(arm.columns.tolist())}
    united = effect_terms(arm.model)
    free = [i for i in range(len(arm.model.robot.parameter_names)) if not arm.fixed_in_both[i]]
    found = []
    for together in groups.values():
        own = [term for effect in together for term in effect_terms(arm.model, [effect])]
        in_a, in_b = ([term for term in own if term in known] for known in terms)
        if not in_a or not in_b or set(in_a) & set(in_b):
            continue
        index = [places[united[term]] for term in own]
        left = projected_out(columns[:, free], columns[:, index], _NULL)
        by_chance = position_std(left, arm.covariance[np.ix_(index, index)])
        apart = Moved.of(left @ arm.difference[index])
        names = tuple(arm.names[i] for i in index)
        found.append(DisjointTerms(together[0].name, names, apart, by_chance, alpha))
    return found
