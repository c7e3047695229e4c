"""The ``kinematics.yaml`` that the ROS packages of Universal Robots read (``ur_description``, ``ur_calibration``).

The file has x, y, z [m], roll, pitch and yaw [rad] of each joint's frame in the one before, at joint angles zero, with the z axes along the
joints, and the checksum of the controller's own calibration.
"""

from __future__ import annotations

import re

import numpy as np

from scalar.data.located_table import shorten
from scalar.errors import Fault, InvalidInput
from scalar.export.numbers_out import shortest
from scalar.export.rigid_part import RigidPart
from scalar.geometry.robot import GEOMETRY, Robot, link_transforms
from scalar.geometry.roll_pitch_yaw import rpy_from_rotation
from scalar.geometry.se3 import Array

LINKS = ("shoulder", "upper_arm", "forearm", "wrist_1", "wrist_2", "wrist_3")
_RIGHT_ANGLES = (0, 1, 0, 0, 1, -1)  # alpha of a UR arm in modified DH
_LIKE = 1e-3  # rad or m: the most by which a nominal arm may differ from the form of a UR arm
NO_HASH = "calib_not_stated"
_HASH = re.compile(r"calib_[A-Za-z0-9_]+")


def ur_kinematics(nominal: Robot, rigid: RigidPart, checksum: str | None, file: str) -> str:
    """Return the text of ``kinematics.yaml``.

    Args:
        nominal: The arm before calibration; its base frame has to be that of the controller, its flange ``tool0``.
        rigid: The calibrated arm.
        checksum: ``calib_...``, which the driver compares with that of the controller; None if the user gave none.
        file: Path of the calibration, for messages.

    Raises:
        InvalidInput: The arm is no UR arm in the frames of its controller, or the checksum has another form.
    """
    _check_form(nominal, file)
    if checksum is not None and not _HASH.fullmatch(checksum):
        message = f"{shorten(checksum)} is no checksum of a controller; write it as its own kinematics.yaml has it: calib_ and a number"
        raise InvalidInput(Fault("--ur-hash", message))
    lines = [
        "# Written by `scalar export`: calibrated kinematics, not those that the controller states.",
        "kinematics:",
    ]
    for link, T in zip(LINKS, link_origins(rigid.robot), strict=True):
        lines.append(f"  {link}:")
        values = (*T[:3, 3], *rpy_from_rotation(T[:3, :3]))
        for key, value in zip(("x", "y", "z", "roll", "pitch", "yaw"), values, strict=True):
            lines.append(f"    {key}: {_number(float(value))}")
    return "\n".join([*lines, f"  hash: {checksum or NO_HASH}", ""])


def link_origins(robot: Robot) -> Array:
    """Return the frame of each joint in the one before, at joint angles zero ``(n, 4, 4)``.

    The first includes the fixed transform of the base, the last that of the flange.
    """
    T = link_transforms(robot.geometry, np.zeros((1, robot.n_joints)))[0]
    T[0] = robot.T_base_0 @ T[0]
    T[-1] = T[-1] @ robot.T_n_flange
    return T


def _check_form(nominal: Robot, file: str) -> None:
    """Raise ``InvalidInput`` if the nominal arm is not a UR arm in the frames of its controller."""

    def refused(what: str) -> InvalidInput:
        return InvalidInput(
            Fault(
                file, f"{what}; kinematics.yaml is for arms of Universal Robots: export a URDF or a DH table"
            )
        )

    if nominal.n_joints != len(LINKS):
        raise refused(f"the arm has {nominal.n_joints} joints, and a UR arm has {len(LINKS)}")
    if nominal.prismatic:
        raise refused(f"joint {nominal.prismatic[0] + 1} slides, and all joints of a UR arm turn")
    alpha, theta, beta = (nominal.geometry[GEOMETRY.index(kind)] for kind in ("alpha", "theta", "beta"))
    wanted = np.array(_RIGHT_ANGLES) * np.pi / 2
    if np.max(np.abs(np.concatenate([alpha - wanted, theta, beta]))) > _LIKE:
        raise refused(
            "the nominal table is not that of a UR arm (alpha 0, 90, 0, 0, 90, -90 degrees, theta 0)"
        )
    if (
        np.max(np.abs(nominal.T_base_0 - np.eye(4))) > _LIKE
        or np.max(np.abs(nominal.T_n_flange - np.eye(4))) > _LIKE
    ):
        message = (
            "base or flange of the nominal arm is not that of the controller (the links 'base' and 'tool0' of ur_description); "
            "calibrate in these frames, or export a URDF"
        )
        raise InvalidInput(Fault(file, message))


def _number(value: float) -> str:
    """Return a number as YAML 1.1 reads it too: with a point before an exponent."""
    text = shortest(value)
    if "e" in text and "." not in text:
        text = text.replace("e", ".0e")
    return text
