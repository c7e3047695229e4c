"""Write a calibration into the URDF of the nominal arm: the origins of its joints are replaced, all else is kept.

The frame of a link keeps its place relative to the axis of its joint (a joint that turns has it on the axis), so that meshes, masses and
the direction of the axis in the link are as before. The origin of every joint takes up the change. The calibrated sensor becomes a link
behind a fixed joint.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from scalar.data.located_table import shorten
from scalar.errors import Fault, InvalidInput
from scalar.export.numbers_out import shortest
from scalar.export.rigid_part import RigidPart, random_joints
from scalar.geometry.robot import Robot
from scalar.geometry.roll_pitch_yaw import rpy_from_rotation
from scalar.geometry.se3 import Array, inverse, rotation_angle, transform
from scalar.ingest.urdf import Chain, ChainJoint, UrdfDocument, chain_between, robot_of_chain
from scalar.units import DEG, MM

SENSOR_LINK = "scalar_sensor"
"""Name of the calibrated sensor's link, unless the user gives another."""
SAME_LENGTH = 2e-3
"""Largest difference in position [m] between a description and the nominal arm that may be rounding.

Chosen: descriptions that round right angles to three digits are off by 0.8 mm at a metre; another arm is off by centimetres."""
SAME_ANGLE = 5e-3
"""The same for orientation [rad]: the sum of six angles rounded to 1.57."""
EXACT = 1e-9
"""Largest difference [m, rad] between the written file and the model that may be rounding."""
_ROUNDING = 1e-12  # m, rad: if the flange is off by no more, its fixed joint is left as it is written


def put_calibration(
    document: UrdfDocument,
    base: str | None,
    tip: str | None,
    nominal: Robot,
    rigid: RigidPart,
    sensor_link: str,
) -> str:
    """Replace the geometry of a description by that of a calibration, in place. Return what became of the sensor's link, in words.

    Args:
        document: The description of the nominal arm.
        base, tip: The links whose frames are the base and the flange of the calibration; None for the root and the only leaf.
        nominal: The nominal arm of the calibration.
        rigid: The calibrated arm.
        sensor_link: Name of the sensor's link, which is made where it is missing.

    Raises:
        InvalidInput: The description is of another arm, or cannot hold the calibration.
    """
    links = document.named("link")
    sensor_exists = sensor_link in links
    if tip is None and sensor_exists:
        tip = _above_sensor(document, sensor_link)
    chain = chain_between(document, base, tip)
    described, _ = robot_of_chain(document.name, chain)
    _check_same_arm(document, chain, described, nominal)
    T_link = _links_of_joints(chain)
    before = _frames(nominal)
    after = _frames(rigid.robot)
    T_flange = after[-1] @ rigid.robot.T_n_flange
    moving = chain.moving
    T_parent, i = chain.T_start, 0
    last_fixed: tuple[ChainJoint, Array] | None = None
    for joint in chain.joints:
        if not joint.moves:
            last_fixed = (joint, T_parent)
            T_parent = T_parent @ joint.T_origin
            continue
        nearest = along_axis if joint.slides else on_axis
        T_joint_link = nearest(inverse(before[i]) @ T_link[i], joint.axis)
        if joint is moving[-1] and joint is chain.joints[-1]:  # the tip itself moves, and is the flange
            T_joint_link = nearest(rigid.robot.T_n_flange, joint.axis)
        T_new = after[i] @ T_joint_link
        _set_origin(joint.element, inverse(T_parent) @ T_new)
        T_parent, i, last_fixed = T_new, i + 1, None
    if last_fixed is not None and np.max(np.abs(T_parent - T_flange)) > _ROUNDING:
        joint, T_above = last_fixed
        _set_origin(joint.element, inverse(T_above) @ T_flange)
    _put_sensor(document, chain.tip, sensor_link, rigid.T_flange_sensor, sensor_exists)
    _check_result(document, chain, rigid, sensor_link)
    if sensor_exists:
        return f"the link '{sensor_link}' stands where the sensor was calibrated"
    return f"a link '{sensor_link}' was added, fixed to '{chain.tip}', where the sensor was calibrated (--sensor-link names it otherwise)"


def on_axis(T: Array, axis: Array) -> Array:
    """Return the frame nearest to T ``(4, 4)`` whose origin is on the z axis of the reference frame, and whose ``axis`` lies along it."""
    frame = along_axis(T, axis)
    frame[:2, 3] = 0.0
    return frame


def along_axis(T: Array, axis: Array) -> Array:
    """Return the frame nearest to T ``(4, 4)``, with the same origin, whose ``axis`` ``(3,)`` lies along the z axis of the reference frame."""
    R = T[:3, :3]
    z = R @ axis
    v, c = np.cross(z, [0.0, 0.0, 1.0]), float(z[2])
    V = np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])
    turn = np.eye(3) + V + V @ V / (1.0 + c)  # the least rotation that takes z to e_z
    return transform(turn @ R, T[:3, 3])


def _frames(robot: Robot) -> Array:
    """Return the frames of the joints at zero ``(n, 4, 4)`` in the base frame."""
    return robot.frames(np.zeros((1, robot.n_joints)))[0, 1:]


def _links_of_joints(chain: Chain) -> list[Array]:
    """Return the frame of each moving joint's link in the base frame at zero, ``(4, 4)`` each."""
    T, found = chain.T_start, []
    for joint in chain.joints:
        T = T @ joint.T_origin
        if joint.moves:
            found.append(T)
    return found


def _check_same_arm(document: UrdfDocument, chain: Chain, described: Robot, nominal: Robot) -> None:
    if described.n_joints != nominal.n_joints:
        message = (
            f"{described.n_joints} joints move from {shorten(chain.base)} to {shorten(chain.tip)}, and {nominal.n_joints} were "
            "calibrated; give the same arm, with --base and --tip"
        )
        raise InvalidInput(Fault(document.file, message))
    for i in np.flatnonzero(described.slides != nominal.slides):
        kinds = ["slides" if robot.slides[i] else "turns" for robot in (described, nominal)]
        message = f"joint {shorten(chain.moving[i].name)} {kinds[0]}, and joint {i + 1} of the calibration {kinds[1]}; give the same arm"
        raise InvalidInput(Fault(document.file, message))
    q = random_joints(nominal)
    off, turned = _difference(described.flange(q), nominal.flange(q))
    if off > SAME_LENGTH or turned > SAME_ANGLE:
        message = (
            f"from {shorten(chain.base)} to {shorten(chain.tip)} it differs from the nominal arm of the calibration by {_in_digits(off / MM)} mm "
            f"and {_in_digits(turned / DEG)} deg; {_remedy(described.flange(q), nominal.flange(q))}"
        )
        raise InvalidInput(Fault(document.file, message))


def _in_digits(number: float) -> str:
    """Return a number with three digits or all before the decimal point, and no power of ten."""
    return f"{number:.0f}" if number >= 1000.0 else f"{number:.3g}"


def _remedy(described: Array, nominal: Array) -> str:
    """Return what to give instead of a description that puts the flange at other frames ``(N, 4, 4)`` than the nominal arm does.

    If the difference is the same at all joint angles, seen from the flange or from the base, the joints agree, and that link alone is another one.
    """
    apart = {
        ("flange", "--tip"): inverse(nominal) @ described,
        ("base", "--base"): described @ inverse(nominal),
    }
    for (link, option), T in apart.items():
        off, turned = _difference(T, T[:1])
        if off <= SAME_LENGTH and turned <= SAME_ANGLE:
            return (
                f"the joints agree, and the frame of the {link} alone is another one: name the link that has the calibration's frame of the {link} "
                f"with {option}, or add that link to the description with a fixed joint"
            )
    return "give the description of the same arm, and the links of its base and flange with --base and --tip"


def _difference(T: Array, other: Array) -> tuple[float, float]:
    """Return the largest distance [m] and the largest angle [rad] between frames ``(N, 4, 4)``."""
    R = np.swapaxes(T[:, :3, :3], 1, 2) @ other[:, :3, :3]
    return float(np.max(np.linalg.norm(T[:, :3, 3] - other[:, :3, 3], axis=1))), float(
        np.max(rotation_angle(R))
    )


def _above_sensor(document: UrdfDocument, sensor_link: str) -> str:
    """Return the link to which the description fixes its link of the sensor.

    Raises:
        InvalidInput: The sensor's link is not fixed to another one.
    """
    for joint in document.named("joint").values():
        child, parent = joint.find("child"), joint.find("parent")
        if child is not None and child.get("link") == sensor_link and joint.get("type") == "fixed":
            return str(None if parent is None else parent.get("link"))
    raise _not_fixed(document, sensor_link, "another link")


def _not_fixed(document: UrdfDocument, sensor_link: str, to: str) -> InvalidInput:
    message = f"the link {shorten(sensor_link)} is not fixed to {to}; give another name with --sensor-link"
    return InvalidInput(Fault(document.file, message))


def _set_origin(element: Any, T: Array) -> None:
    origin = element.find("origin")
    if origin is None:
        origin = element.makeelement("origin")
        element.insert(0, origin)
    for key, values in (("xyz", T[:3, 3]), ("rpy", rpy_from_rotation(T[:3, :3]))):
        origin.set(key, " ".join(map(shortest, values)))


def _put_sensor(document: UrdfDocument, tip: str, name: str, T_flange_sensor: Array, exists: bool) -> None:
    """Add the sensor's link behind the tip; if the link exists, set the origin of the joint before it."""
    root = document.root
    if not exists:
        link = root.makeelement("link", {"name": name})
        joint = root.makeelement("joint", {"name": f"{name}_joint", "type": "fixed"})
        for tag, target in (("parent", tip), ("child", name)):
            joint.append(joint.makeelement(tag, {"link": target}))
        _set_origin(joint, T_flange_sensor)
        for element in (link, joint):
            element.tail = "\n"
            root.append(element)
        return
    chain = chain_between(document, tip, name, may_be_fixed=True) if tip != name else None
    if chain is None or chain.moving or not chain.joints:
        raise _not_fixed(document, name, shorten(tip))
    T = chain.T_start
    for joint in chain.joints[:-1]:
        T = T @ joint.T_origin
    _set_origin(chain.joints[-1].element, inverse(T) @ T_flange_sensor)


def _check_result(document: UrdfDocument, chain: Chain, rigid: RigidPart, sensor_link: str) -> None:
    """Read the finished description back, and raise ``InvalidInput`` if its sensor is not where the model has it."""
    made, _ = robot_of_chain(document.name, chain_between(document, chain.base, sensor_link))
    q = random_joints(rigid.robot)
    off, turned = _difference(made.flange(q), rigid.robot.flange(q) @ rigid.T_flange_sensor)
    if off > EXACT or turned > EXACT:
        message = (
            f"a URDF with the flange at {shorten(chain.tip)} would be off by {off / MM:.3g} mm, since a link that turns lies on its axis; "
            "give --tip as a link behind a fixed joint"
        )
        raise InvalidInput(Fault(document.file, message))


def text_of(document: UrdfDocument, calibration: str) -> str:
    """Return the description as text, with a comment at its beginning that names the calibration."""
    import lxml.etree as etree

    name = calibration.replace("--", "- -").rstrip("-")
    comment = etree.Comment(
        f" Joint origins by scalar, from {name}; effects that change from pose to pose are not in a URDF. "
    )
    comment.tail = "\n"
    document.root.insert(0, comment)
    text: bytes = etree.tostring(document.root.getroottree(), xml_declaration=True, encoding="utf-8")
    return text.decode("utf-8") + "\n"
