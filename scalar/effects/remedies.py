"""Sentences that several effects share: what changes in the controller, and how to see an error directly."""

from __future__ import annotations

PERIODIC = "No DH parameter holds a periodic error of a joint: correct the joint angles of each program with 'scalar correct', which applies it."
NOTHING_IN_CONTROLLER = "Nothing changes in the controller, because it is not the arm that errs."
ON_A_STAGE = (
    "To see it directly, move the scanner on a linear stage towards a flat surface, and compare its readings with the stage's over the whole "
    "range of measurement."
)
