"""Advise to record the load on the flange if the arm gives way and no column says what it carried.

The advice names no cause. A load that was in the gripper at some of the poses leaves structure that the recorded columns do not explain, and so do
many other things; but a load is easily recorded, and then tried by name.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from scalar.data.formats import PAYLOAD, TORQUE
from scalar.diagnosis.naming.finding import UNATTRIBUTED
from scalar.effects.effect import WEIGHT

if TYPE_CHECKING:
    from scalar.diagnosis.result import Diagnosis

_HOW = (
    f"in poses.csv, the column {PAYLOAD[0]} [kg], 0 where there was none, with its centre of mass in the frame of the flange in "
    f"{', '.join(PAYLOAD[1:])} [m]; or the torques of all joints, {TORQUE}1, {TORQUE}2, … [N m] (format: scalar-dataset/2 in dataset.yaml)"
)


def load_advice(diagnosis: Diagnosis) -> list[str]:
    """Return a sentence on recording the load, if something was found that depends on it or may hide it; nothing where a load is recorded."""
    columns = {str(name) for name in diagnosis.dataset.poses.columns}
    if PAYLOAD[0] in columns or f"{TORQUE}1" in columns:
        return []
    gives_way = any(finding.effect.load == WEIGHT for finding in diagnosis.findings)
    unexplained = diagnosis.verdict == UNATTRIBUTED or any(finding.doubtful for finding in diagnosis.findings)
    sentences = []
    if gives_way:
        sentences.append(
            f"Record what the flange carried at each pose: {_HOW}. These data have neither, so that the compliance that was found holds for the load "
            "of this campaign only."
        )
    if unexplained:
        how = "" if gives_way else f": {_HOW}"
        sentences.append(
            "If the flange carried a part, a tool or a cable at some of these poses and not at others, record that too, and run again"
            f"{how}. Such a load leaves structure that the present columns do not explain; these data do not tell whether there was one."
        )
    return [" ".join(sentences)] if sentences else []
