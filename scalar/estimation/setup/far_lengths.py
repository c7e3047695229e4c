"""By how much a length of an arm may differ from its table of joints, and which differ by more."""

from __future__ import annotations

import numpy as np

from scalar.geometry.robot import GEOMETRY, LENGTHS, Robot
from scalar.geometry.standard_dh import as_stated
from scalar.units import MM

LINK_SHARE = 0.02  # of the arm's length: real links differ from their table by a millimetre or two, and reference frames by a few more
LEAST_LINK = 10 * MM  # the limit for a link is at least this, however short the arm


def most_of_a_link(robot: Robot) -> float:
    """Return by how much a length of an arm may differ from its table [m]."""
    lengths = [k for k, kind in enumerate(GEOMETRY) if kind in LENGTHS]
    return max(LEAST_LINK, LINK_SHARE * float(np.abs(robot.geometry[lengths]).sum()))


def far_length_in_words(nominal: Robot, fitted: Robot) -> str:
    """Return a clause about the length of a fitted arm that is farthest from its table, for the end of a sentence; empty if all are near it."""
    lengths = [k for k, kind in enumerate(GEOMETRY) if kind in LENGTHS]
    change = np.abs(fitted.geometry - nominal.geometry)[lengths]
    change[:, nominal.slides] = 0.0
    k, joint = np.unravel_index(int(np.argmax(change)), change.shape)
    if change[k, joint] <= most_of_a_link(nominal):
        return ""
    name = as_stated(f"{GEOMETRY[lengths[k]]}_{joint + 1}", nominal)
    off = f"{change[k, joint] / MM:.0f} mm"
    return f"; but {name} comes out {off} from the table of joints even then: is this another robot than the one that was measured?"
