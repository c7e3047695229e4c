"""Planes that are declared known, and lie elsewhere by the data: the declaration is wrong, or it was made in another frame.

A wrong declaration often leaves no residual of the scans, since the whole arm may move with its planes. That the fit has the plane many standard
deviations from where it is declared is then all that shows it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from scalar.data.dataset import Dataset
from scalar.errors import Fault, InvalidInput
from scalar.estimation.model import Model
from scalar.estimation.reference_planes import ReferencePlanes
from scalar.estimation.setup.planes.wrongly_known_planes import (
    SURELY_FALLS,
    fit_without_declarations,
    known_names,
    with_and_without,
)
from scalar.geometry.planes import Planes
from scalar.units import DEG, MM

SIGMAS = 5.0  # stated standard deviations: a plane farther from where it is declared is suspect
LEAST_SHIFT, LEAST_TURN = 1 * MM, 0.2 * DEG
"""What effects of arm and sensor that a model lacks may shift or turn a plane by."""
SURELY = 20.0  # stated standard deviations beyond which no error of measurement is plausible
SURE_SHIFT, SURE_TURN = 5 * MM, 1 * DEG  # beyond what any effect of arm and sensor causes


@dataclass(frozen=True)
class Contradiction:
    """A plane that the data have elsewhere than dataset.yaml declares it known.

    Attributes:
        plane: Its name.
        sentence: Where it is declared and where the data have it, and what to do.
        certain: Whether no error of measurement, of arm or of sensor explains it.
    """

    plane: str
    sentence: str
    certain: bool


class KnownPlaneContradicted(InvalidInput):
    """A plane is declared known where the data surely do not have it."""


def contradictions(dataset: Dataset, model: Model) -> list[Contradiction]:
    """Return the known planes that a fit has many of their stated standard deviations from where they are declared.

    Args:
        dataset: What was measured.
        model: Where the fit ended.
    """
    planes, known = model.target, ReferencePlanes.of(dataset, model.target)
    if known is None or not isinstance(planes, Planes):
        return []
    declared = planes.normals.copy()
    declared[known.index] = known.normals
    turns, distances = planes.relative_to(declared)
    found = []
    for i, k in enumerate(known.index):
        name, turn, distance = planes.names[k], float(turns[k]), float(distances[k])
        shift = abs(distance - float(known.distances[i]))
        shift_in_std, turn_in_std = shift / float(known.distance_std[i]), turn / float(known.normal_std[i])
        if shift_in_std > SIGMAS and shift > LEAST_SHIFT:
            sentence = (
                f"plane {name} is declared known to {known.distance_std[i] / MM:.3g} mm at the distance {known.distances[i] / MM:.1f} mm, and "
                f"the data put it at {distance / MM:.1f} mm, {shift / MM:.3g} mm away: check the declared distance (in the base frame of the table "
                "of joints), or remove known"
            )
            found.append(Contradiction(name, sentence, shift_in_std > SURELY and shift > SURE_SHIFT))
        if turn_in_std > SIGMAS and turn > LEAST_TURN:
            sentence = (
                f"the normal of plane {name} is declared known to {known.normal_std[i] / DEG:.3g} degrees, and the data turn it by {turn / DEG:.3g} "
                "degrees: check the declared normal (in the base frame of the table of joints), or remove known"
            )
            found.append(Contradiction(name, sentence, turn_in_std > SURELY and turn > SURE_TURN))
    return found


def refuse_contradicted_planes(dataset: Dataset, model: Model) -> None:
    """Refuse a dataset that declares a plane known where the data surely do not have it.

    Raises:
        KnownPlaneContradicted: Naming every such plane, with its declared and its fitted place; or all of them, where only a fit without any leaves a
            clearly smaller residual.
    """
    certain = [found for found in contradictions(dataset, model) if found.certain]
    if not certain:
        compared = with_and_without(dataset, model)
        if compared is not None and compared.residual_falls > SURELY_FALLS:
            names = known_names(dataset)
            raise KnownPlaneContradicted(
                Fault("dataset.yaml", compared.sentence(names), None, "planes.known")
            )
        return
    # The fit compromises between the declaration and the data sheet: where the data have the planes shows without the declaration.
    trial = fit_without_declarations(dataset)
    names = {found.plane for found in certain}
    undeclared = (
        [] if trial is None else [c for c in contradictions(dataset, trial.model) if c.plane in names]
    )
    raise KnownPlaneContradicted(
        Fault("dataset.yaml", found.sentence, None, f"planes.{found.plane}.known")
        for found in undeclared or certain
    )


def base_moved_to(dataset: Dataset, model: Model) -> tuple[str, ...]:
    """Return the names of the planes whose declared distances a shift of the first axis from the data sheet may satisfy.

    The data show where the planes are relative to the first axis. If one is declared elsewhere, and nothing else says where the axis is in the base
    frame, then the lengths of the first link change, and the plane lies where it is declared.

    Args:
        dataset: What was measured.
        model: Where the fit ended.
    """
    at_zero = np.zeros((1, model.robot.n_joints))
    fitted, nominal = (robot.frames(at_zero)[0, 1, :3, 3] for robot in (model.robot, dataset.robot))
    shift = fitted - nominal
    return tuple(
        plane.name
        for plane in dataset.planes
        if plane.distance_std is not None and abs(plane.normal @ shift) > LEAST_SHIFT
    )
