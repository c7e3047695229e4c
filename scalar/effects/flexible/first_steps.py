"""What to do first about unmodelled structure: measurements and checks that show its cause, by what it varies with."""

from __future__ import annotations

from collections.abc import Sequence

from scalar.data.poses import is_joint
from scalar.effects.title import joints_in_words
from scalar.effects.wording import columns_in_words

_STEPS = {
    "gravity": "Turn the wrist so that the sensor hangs to every side, and check that its mount on the flange is tight and stiff.",
    "order": "Repeat the first poses at the end of the acquisition: if they come out different, something moves or warms up meanwhile.",
    "time": "Repeat the first poses at the end of the acquisition: if they come out different, something moves or warms up meanwhile.",
    "temperature": "Measure the same poses with the arm cold and with the arm warm, and compare them.",
    "session": "Measure some of the same poses in each session: if they come out different, something was changed between the sessions.",
    "plane_u": "Measure the same spot of a target plane from different poses: if the error stays with the spot, the surface is uneven there.",
    "plane_v": "Measure the same spot of a target plane from different poses: if the error stays with the spot, the surface is uneven there.",
}


def first_steps(names: Sequence[str]) -> list[str]:
    """Return whole sentences on what to do about structure that varies with some quantities, each sentence once.

    Args:
        names: Columns of poses.csv, ``gravity``, or ``plane_u`` and ``plane_v`` for the place on a target plane.
    """
    joints = [int(name[1:]) for name in names if is_joint(name)]
    found = []
    if joints:
        found.append(
            f"Sweep {joints_in_words(joints)} in small steps{', one at a time,' if len(joints) > 1 else ''} while all other joints stand still: "
            "the curve of the residual over the joint's position shows more of the cause than random poses do."
        )
    for name in names:
        if not is_joint(name):
            found.append(
                _STEPS.get(
                    name,
                    f"Measure the same poses at several values of {columns_in_words([name])}, and compare them.",
                )
            )
    return list(dict.fromkeys(found))
