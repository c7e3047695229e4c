"""Planes whose initial guess is far from where a fit has them. The fit found them all the same; the guess may be a mistake in dataset.yaml."""

from __future__ import annotations

import numpy as np

from scalar.data.dataset import Dataset
from scalar.estimation.model import Model
from scalar.estimation.setup.mirror_image import or_wrong_signs
from scalar.geometry.planes import Planes
from scalar.sensors import Target
from scalar.units import MM

ALONG_Y = 0.7  # component of a normal along y from which on a plane lies on one side of the arm
FAR = 200 * MM  # twice the error of a guess from which a fit is documented to start


def far_guesses(dataset: Dataset, model: Model, guess: Target) -> list[tuple[str, str]]:
    """Return the name of every plane whose guessed distance is far off, and a sentence with the figures.

    A guess that is tilted has another distance from the base's origin at the same points; as much as a tilt explains is not counted.

    Args:
        dataset: What was measured.
        model: Where the fit ended.
        guess: The target at its initial guess.
    """
    planes = model.target
    if not (isinstance(planes, Planes) and isinstance(guess, Planes)):
        return []
    found = []
    declared = {plane.name for plane in dataset.planes if plane.distance_std is not None}
    turns, distances = planes.relative_to(guess.normals)
    for name, normal, turn, fitted, guessed in zip(
        planes.names, guess.normals, turns, distances, guess.distances, strict=True
    ):
        if name in declared or name.split("@")[0] in declared:
            continue
        # The mirror image of an arm is that at the plane of x and z, in which it stands with all joints at zero.
        mirrored = abs(fitted + guessed) < FAR and abs(normal[1]) > ALONG_Y
        if abs(fitted - guessed) > FAR + max(abs(fitted), abs(guessed)) * np.sin(turn):
            sentence = (
                f"the guess of plane {name} is far off: dataset.yaml has the distance {guessed / MM:.0f} mm, and the data put it at "
                f"{fitted / MM:.0f} mm; the plane was found all the same, but look whether "
                "the number, its sign or the plane's name is a mistake"
            ) + (or_wrong_signs(dataset.robot) if mirrored else "")
            found.append((name, sentence))
    return found
