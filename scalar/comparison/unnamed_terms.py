"""The flexible terms of a calibration: what they change, and how far they move predicted positions.

They correct structure without naming its cause, so they have no name for ``--effects``, and the terms of two campaigns are rarely the same ones.
A reader can compare their sizes; their coefficients cannot be compared.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from scalar.comparison.invariants import N_POSES, NEGLIGIBLE
from scalar.comparison.moved import Moved
from scalar.data.poses import Poses, is_joint
from scalar.effects.effect import Effect
from scalar.effects.flexible.variable import Variable
from scalar.effects.places import PointEffect
from scalar.estimation.displacement import base_and_sensor_columns, kinematics_at, projected_out
from scalar.estimation.model import Model
from scalar.estimation.random_poses import random_poses

_SEED = 1


@dataclass(frozen=True, eq=False)
class UnnamedTerm:
    """One flexible term of a calibration.

    Attributes:
        described_as: What it changes, a noun clause.
        moved: How far it moves predicted positions over random poses, after the best fit of base and sensor. An order, a time or another record that
            it depends on takes random values of the range to which it was fitted.
        stays_with_arm: Whether another campaign with the same arm would show it as well.
    """

    described_as: str
    moved: Moved
    stays_with_arm: bool

    def to_mapping(self) -> dict[str, object]:
        """Return the entry of ``comparison.json``."""
        return {"described_as": self.described_as, **self.moved.to_mapping()}


def unnamed_terms(model: Model) -> tuple[UnnamedTerm, ...]:
    """Return the flexible terms of a model that move the arm, those that move positions most first."""
    terms = [
        UnnamedTerm(effect.described_as, _moved(model, effect), effect.stays_with_arm)
        for effect in model.effects
        if effect.flexible
        and not isinstance(effect, PointEffect)  # an error of the scanner moves no predicted position
    ]
    return tuple(sorted(terms, key=lambda term: -term.moved.rms))


def _moved(model: Model, effect: Effect) -> Moved:
    """Return how far one effect alone moves positions."""
    poses = _poses_for(model, effect)
    with_it, without = (
        kinematics_at(replace(model, effects=effects), poses).T_base_sensor for effects in ((effect,), ())
    )
    moved = (with_it[:, :3, 3] - without[:, :3, 3]).reshape(-1, 1)
    return Moved.of(projected_out(base_and_sensor_columns(without), moved, NEGLIGIBLE))


def _poses_for(model: Model, effect: Effect) -> Poses:
    """Return random poses with every record that the effect depends on, drawn from the range to which it was fitted."""
    rng = np.random.default_rng(_SEED)
    poses = random_poses(model, N_POSES)
    order, columns = poses.order, dict(poses.columns)
    for variable in _variables(effect):
        values = rng.uniform(variable.centre - variable.half, variable.centre + variable.half, len(poses))
        if variable.name == "order":
            order = values
        elif not is_joint(variable.name):
            columns[variable.name] = values
    return replace(poses, order=order, columns=columns)


def _variables(effect: Effect) -> list[Variable]:
    """Return the variables of a flexible term, each of which states its range."""
    fields = [value if isinstance(value, tuple) else (value,) for value in vars(effect).values()]
    return [value for values in fields for value in values if isinstance(value, Variable)]
