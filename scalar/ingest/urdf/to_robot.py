"""Convert a chain of a robot description to a robot that has the same poses at the same joint angles and travels."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from scalar.geometry.from_axes import frame_on_axis, robot_from_axes
from scalar.geometry.robot import Robot
from scalar.geometry.se3 import Array, inverse
from scalar.ingest.urdf.chain import Chain, chain_between
from scalar.ingest.urdf.document import read_urdf


def read_robot(path: str | Path, base: str | None = None, tip: str | None = None) -> Robot:
    """Return the chain between two links of a URDF as a robot: the nominal arm of a dataset, say.

    Args:
        path: The file.
        base: Name of the link whose frame is the robot's base; None for the root.
        tip: Name of the link whose frame is the flange; None for the only link without a child.

    Returns:
        The robot, whose ``flange(q)`` ``(N, 4, 4)`` is the tip's frame in the base's frame at joint angles and travels ``q`` ``(N, n)`` [rad, m], in
        the order of the moving joints from base to tip.

    Raises:
        InvalidInput: The file is no URDF, or has no serial chain of revolute, prismatic and fixed joints between these links.

    Example:
        A link of 0.4 m that turns about z, and a slide along it:

        >>> from pathlib import Path
        >>> import numpy as np
        >>> import scalar
        >>> joint = '<joint name="{}" type="{}"><parent link="{}"/><child link="{}"/><origin xyz="{} 0 0"/><axis xyz="{}"/>{}</joint>'
        >>> limit = '<limit lower="0" upper="0.3" effort="1" velocity="1"/>'
        >>> text = "".join(f'<link name="{name}"/>' for name in ("base", "upper", "tip"))
        >>> text += joint.format("turn", "continuous", "base", "upper", 0.0, "0 0 1", "")
        >>> text += joint.format("slide", "prismatic", "upper", "tip", 0.4, "1 0 0", limit)
        >>> _ = Path("arm.urdf").write_text(f'<robot name="arm">{text}</robot>')
        >>> robot = scalar.read_robot("arm.urdf", base="base", tip="tip")
        >>> robot.n_joints, robot.prismatic
        (2, (1,))
        >>> T_base_flange = robot.flange(np.array([[np.pi / 2, 0.1]]))
        >>> np.abs(T_base_flange[0, :3, 3]).round(12).tolist()
        [0.0, 0.5, 0.0]
    """
    return robot_from_urdf(path, base, tip)[0]


def robot_from_urdf(path: str | Path, base: str | None = None, tip: str | None = None) -> tuple[Robot, Array]:
    """Return the chain between two links of a URDF as a robot, and where the links are in the robot's frames.

    Args:
        path: The file.
        base: Name of the link whose frame is the robot's base; it carries the chain, or is fixed to the link that does. None for the root.
        tip: Name of the link whose frame is the flange; None for the only link without a child.

    Returns:
        The robot, whose ``flange(q)`` is the tip's frame in the base's frame when the i-th moving joint is at ``q_i``; and for each i the
        fixed transform ``T_i_link``, ``(n, 4, 4)`` for all, of the frame of the link that this joint moves in the robot's frame i.

    Raises:
        InvalidInput: The file is no URDF, or has no serial chain of revolute, prismatic and fixed joints between these links.
    """
    document = read_urdf(path)
    return robot_of_chain(document.name, chain_between(document, base, tip))


def robot_of_chain(name: str, chain: Chain) -> tuple[Robot, Array]:
    """Return a chain as a robot, and the fixed transforms ``(n, 4, 4)`` of its links in the robot's frames, as ``robot_from_urdf`` does.

    Args:
        name: Name of the robot.
        chain: A chain with at least one moving joint.
    """
    standing = chain.T_start
    links: list[Array] = []
    axes: list[Array] = []
    for joint in chain.joints:
        standing = standing @ joint.T_origin
        if joint.moves:
            links.append(standing)
            axes.append(frame_on_axis(standing, joint.axis))
    limits = np.array([joint.limits for joint in chain.moving])
    prismatic = tuple(i for i, joint in enumerate(chain.moving) if joint.slides)
    robot = robot_from_axes(name, np.array(axes), standing, limits, prismatic)
    frames = robot.frames(np.zeros((1, robot.n_joints)))[0, 1:]
    return robot, inverse(frames) @ np.array(links)
