"""Read the truth of a simulated dataset: the folder that ``scalar simulate`` writes next to the dataset."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from scalar.data.io.json_reader import read_json
from scalar.data.io.run_id import RUN, check_truth_run
from scalar.data.pose_tables import read_pose_table
from scalar.errors import Fault, InvalidInput
from scalar.estimation.frame_tables import FRAME_COLUMNS
from scalar.geometry.robot import GEOMETRY, Robot
from scalar.geometry.se3 import Array
from scalar.units import DEG, MM

if TYPE_CHECKING:
    import pandas as pd

# Chosen: uncalibrated arms err by millimetres and by a degree or so, and two arms differ by more than this in a length or a twist.
_OTHER_LENGTH, _OTHER_ANGLE = 30 * MM, 10 * DEG
_MOST_ERROR = 20 * MM  # mean error of positions that no calibration of the right arm has


def read_truth(
    folder: Path, n_joints: int, limits: Array | None = None, prismatic: Sequence[int] = ()
) -> tuple[pd.DataFrame, dict[str, Any] | None]:
    """Return the true poses of a simulated dataset and the content of its ``truth.json``, None where that file is missing.

    Args:
        folder: With ``truth_poses.csv``.
        n_joints: Number n of joints of the robot.
        limits: ``(n, 2)`` [rad, m], which the joints of the true poses must keep; or None.
        prismatic: Indices, from 0, of the prismatic joints.

    Raises:
        InvalidInput: There are no true poses, or a file is damaged.
    """
    poses = read_pose_table(folder / "truth_poses.csv", n_joints, FRAME_COLUMNS, limits, prismatic=prismatic)
    path = folder / "truth.json"
    if not path.exists():
        return poses, None
    content = read_json(path)
    try:
        _check_truth(content)
    except (TypeError, ValueError, KeyError, AttributeError):
        message = "not a truth: expected 'parameters' and 'planes' as 'scalar simulate' writes them"
        raise InvalidInput([Fault(str(path), message)]) from None
    check_truth_run(folder, content.get(RUN))
    return poses, content


def refuse_truth_of_another_robot(
    folder: Path, truth: Mapping[str, Any] | None, nominal: Robot, aligned: float
) -> None:
    """Refuse a truth whose arm is far from the one that was calibrated, in its table of joints and in the places of its sensor.

    The table alone does not decide it, since one arm may be described in several ways; nor do the places, since a calibration may be bad.

    Args:
        folder: The folder of the truth.
        truth: Content of ``truth.json``; None if there is none.
        nominal: The arm before calibration.
        aligned: Mean distance [m] of predicted and true positions, after the best fit of base and sensor.

    Raises:
        InvalidInput: The truth is that of another robot.
    """
    if truth is None or aligned <= _MOST_ERROR:
        return
    for name, most, unit in (("a", _OTHER_LENGTH, "m"), ("alpha", _OTHER_ANGLE, "rad")):
        true = np.array(truth.get("parameters", {}).get(name, []), dtype=float).reshape(-1)
        ours = nominal.geometry[GEOMETRY.index(name)]
        if true.shape != ours.shape:
            continue
        off = np.abs(true - ours)
        if off.max() > most:
            k = int(off.argmax())
            whose = f" ('{robot}')" if (robot := truth.get("robot")) else ""
            values = f"{true[k]:.4g} {unit}, that of '{nominal.name}' is {ours[k]:.4g} {unit}"
            message = (
                f"the truth of another robot{whose}: its {name}_{k + 1} is {values}, and even "
                f"aligned the positions differ by {aligned / MM:.0f} mm; give the truth of the dataset that was calibrated"
            )
            raise InvalidInput(Fault(str(folder / "truth.json"), message))


def _check_truth(content: Any) -> None:
    """Refuse a truth whose lists are not lists of numbers, or whose planes do not belong together.

    Raises:
        ValueError, TypeError, KeyError, AttributeError: Something is not what ``scalar simulate`` writes.
    """
    parameters, planes = content.get("parameters", {}), content.get("planes")
    for key in (*GEOMETRY, "t", "r"):
        _numbers(parameters.get(key, []))
    if planes is None:
        return
    normals = np.array([_numbers(row) for row in _listed(planes["normals"])]).reshape(-1, 3)
    if not np.all(np.linalg.norm(normals, axis=1) > 0.0):
        raise ValueError("a normal of no length")
    names = planes.get("names")
    for column in (_numbers(planes["distances"]), *(() if names is None else (_listed(names),))):
        if len(column) != len(normals):
            raise ValueError("planes without one normal, distance and name each")


def _listed(value: Any) -> list[Any]:
    """Return a list as it is; whatever else may be iterated, such as text or a mapping, is an error."""
    if not isinstance(value, list):
        raise TypeError("not a list")
    return value


def _numbers(value: Any) -> list[float]:
    """Return a list of numbers as floats; text that looks like a number is none."""
    if any(isinstance(x, bool) or not isinstance(x, int | float) for x in _listed(value)):
        raise TypeError("not a list of numbers")
    return [float(x) for x in value]
