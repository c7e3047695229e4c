"""By how much a length of an arm may differ from its table of joints, and which differ by more."""

from __future__ import annotations

import numpy as np

from scalar.estimation.setup.alternatives import Alternative
from scalar.estimation.setup.trial import NominalFit, Trial
from scalar.geometry.robot import GEOMETRY, LENGTHS, Robot
from scalar.geometry.se3 import Array
from scalar.geometry.standard_dh import as_stated
from scalar.robots import arms_with_axes_of
from scalar.units import MM

LINK_SHARE = 0.02  # of the arm's length: real links differ from their table by a millimetre or two, and reference frames by a few more
LEAST_LINK = 10 * MM  # the limit for a link is at least this, however short the arm


def most_of_a_link(robot: Robot) -> float:
    """Return by how much a length of an arm may differ from its table [m]."""
    lengths = [k for k, kind in enumerate(GEOMETRY) if kind in LENGTHS]
    return max(LEAST_LINK, LINK_SHARE * float(np.abs(robot.geometry[lengths]).sum()))


def has_far_length(nominal: Robot, fitted: Robot) -> bool:
    """Return whether a length of a fitted arm is farther from its table than lengths of real arms are."""
    return bool(_off_table(nominal, fitted).max() > most_of_a_link(nominal))


def _off_table(nominal: Robot, fitted: Robot) -> Array:
    """Return by how much the lengths of a fitted arm differ from their table, ``(2, n)`` [m] in the order of ``GEOMETRY``; 0 where a joint slides."""
    lengths = [k for k, kind in enumerate(GEOMETRY) if kind in LENGTHS]
    change = np.abs(fitted.geometry - nominal.geometry)[lengths]
    change[:, nominal.slides] = 0.0
    return change


def with_lengths_near_table(
    found: list[tuple[NominalFit, Alternative, Trial]],
) -> list[tuple[NominalFit, Alternative, Trial]]:
    """Return the alternatives under which all lengths come out near their table: with a wrong sign or zero, a far length may take up what remains.

    Args:
        found: Alternatives that explain the data, each with its nominal and its full fit.
    """
    return [entry for entry in found if not has_far_length(entry[1].dataset.robot, entry[2].model.robot)]


def far_length_in_words(nominal: Robot, fitted: Robot) -> str:
    """Return a clause about the length of a fitted arm that is farthest from its table, for the end of a sentence; empty if all are near it."""
    lengths = [k for k, kind in enumerate(GEOMETRY) if kind in LENGTHS]
    change = _off_table(nominal, fitted)
    k, joint = np.unravel_index(int(np.argmax(change)), change.shape)
    if change[k, joint] <= most_of_a_link(nominal):
        return ""
    name = as_stated(f"{GEOMETRY[lengths[k]]}_{joint + 1}", nominal)
    off = f"{change[k, joint] / MM:.0f} mm"
    asked = "is this another robot than the one that was measured?"
    return f"; but {name} comes out {off} from the table of joints even then: {asked}{arms_in_words(fitted)}"


def arms_in_words(fitted: Robot, before: str = "") -> str:
    """Return a sentence that names the arms of the library whose axes are those of a fitted arm; nothing if there are none.

    Args:
        fitted: The arm.
        before: What stands before the sentence, if there is one.
    """
    arms = arms_with_axes_of(fitted)
    if not arms:
        return ""
    named = " or ".join(f"{arm.maker} {arm.model} ('{arm.name}' of the library)" for arm in arms)
    return f"{before} {'the' if before else 'The'} distances between its axes are those of {named}"
