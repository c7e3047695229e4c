"""The arm as a URDF, which pybullet reads: from then on pybullet's own kinematics is the truth.

Each joint has one fixed origin, T_{i-1,i} at q = 0 with Tz(d) in it, and turns about its own z. Numbers are
printed with 17 digits, so the engine's arm has exactly these numbers. The frames of flange and
sensor are links of their own with their centre of mass at the origin, since the centre of mass is what
pybullet reports in double precision.

An arm without weights gets placeholders, since kinematics does not depend on them. Inertias are always placeholders,
since the arm never accelerates.
"""

import numpy as np

from scalar.simulation.arm import Arm
from scalar.simulation.body import Body, Box, Capsule
from scalar.simulation.transforms import Array, rpy_from_rotation

UNLIMITED = 1e3  # effort and velocity, which a URDF has to state
NO_CENTRE = (0.0, 0.0, 0.0)
WEIGHTLESS = 1e-9  # kg; a link of mass zero would be taken for one that never moves


def _numbers(values: Array | tuple[float, ...]) -> str:
    return " ".join(f"{value:.17g}" for value in values)


def _inertial(mass: float, centre: Array | tuple[float, ...]) -> str:
    return (
        f'<inertial><origin xyz="{_numbers(centre)}" rpy="0 0 0"/><mass value="{mass:.17g}"/>'
        '<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>'
    )


def _origin(T: Array) -> str:
    return f'<origin xyz="{_numbers(T[:3, 3])}" rpy="{_numbers(rpy_from_rotation(T[:3, :3]))}"/>'


def _along(start: Array, end: Array) -> Array:
    """Return a frame (4, 4) in the middle of a segment with its z along it."""
    z = (end - start) / np.linalg.norm(end - start)
    x = np.cross(np.eye(3)[np.argmin(np.abs(z))], z)
    x = x / np.linalg.norm(x)
    T = np.eye(4)
    T[:3, :3] = np.column_stack([x, np.cross(z, x), z])
    T[:3, 3] = (start + end) / 2
    return T


def _solid(solid: Capsule | Box) -> str:
    if isinstance(solid, Capsule):
        origin = _origin(_along(solid.start, solid.end))
        shape = f'<capsule radius="{solid.radius:.17g}" length="{solid.length:.17g}"/>'
    else:
        T = np.eye(4)
        T[:3, 3] = solid.centre
        origin, shape = _origin(T), f'<box size="{_numbers(solid.size)}"/>'
    geometry = f"{origin}<geometry>{shape}</geometry>"
    return f"<visual>{geometry}</visual><collision>{geometry}</collision>"


def urdf_of(arm: Arm, body: Body | None = None) -> str:
    """Return the URDF text of an arm.

    Args:
        arm: its true geometry.
        body: its solids; None leaves them out, which loads much faster where only kinematics is asked for.
    """
    n = arm.n
    names = ["base", *(f"link{i + 1}" for i in range(n)), "flange", "sensor"]
    inertials = [_inertial(1.0, NO_CENTRE)] * len(names)
    if arm.weights is not None:
        links = zip(arm.weights.masses, arm.weights.centres, strict=True)
        inertials[1 : n + 1] = [_inertial(mass, centre) for mass, centre in links]
        inertials[n + 1] = _inertial(WEIGHTLESS, NO_CENTRE)
        inertials[n + 2] = _inertial(arm.weights.sensor or WEIGHTLESS, NO_CENTRE)
    lines = ['<?xml version="1.0"?>', f'<robot name="{arm.name}">']
    for k, name in enumerate(names):
        solids = () if body is None else (solid for solid in body.solids if solid.link == k - 1)
        lines.append(f'<link name="{name}">{inertials[k]}{"".join(map(_solid, solids))}</link>')
    for i in range(n):
        T = arm.joint_origin(i)
        if i == 0:
            T = arm.T_base_0 @ T
        lower, upper = arm.limits[i]
        lines.append(
            f'<joint name="joint{i + 1}" type="revolute">'
            f'<parent link="{names[i]}"/><child link="{names[i + 1]}"/>'
            f'{_origin(T)}<axis xyz="0 0 1"/><limit lower="{lower:.17g}" upper="{upper:.17g}" '
            f'effort="{UNLIMITED:g}" velocity="{UNLIMITED:g}"/></joint>'
        )
    for k, T in ((n, arm.T_n_flange), (n + 1, arm.T_flange_sensor)):
        lines.append(
            f'<joint name="{names[k + 1]}_fixed" type="fixed">'
            f'<parent link="{names[k]}"/><child link="{names[k + 1]}"/>{_origin(T)}</joint>'
        )
    return "\n".join([*lines, "</robot>", ""])
