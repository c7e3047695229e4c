"""Sentences that several effects share: what to change in the robot's controller, and how to see an error directly."""

from __future__ import annotations

CORRECT_PROGRAMS = (
    "No DH parameter holds a periodic error of a joint: correct the joint angles of each program with 'scalar correct', "
    "which applies it."
)
NOTHING_FOR_THE_SCANNER = (
    "The error of the scanner asks for no change in the controller, because it is not the arm that errs."
)
NOTHING_FOR_THE_INSTRUMENT = "The error of the measuring instrument asks for no change in the controller, because it is not the arm that errs."
MEASURE_ON_A_STAGE = (
    "To see it directly, move the scanner on a linear stage towards a flat surface, and compare its readings with the stage's over the whole "
    "range of measurement."
)


def nothing_for_the_plane(name: str) -> str:
    """Return that an error of a target plane changes nothing in the controller."""
    return f"The error of target plane {name} asks for no change in the controller, because it is not the arm that errs."
