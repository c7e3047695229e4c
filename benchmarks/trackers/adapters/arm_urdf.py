"""A table of modified DH parameters as a URDF, for packages that read nothing else."""

from __future__ import annotations

import numpy as np
from exchange import Job, link

FLANGE = "flange"


def urdf(job: Job) -> str:
    """Return the nominal arm as a URDF: each joint turns about z of a frame that alpha and a place, behind theta and d of the joint before."""
    parts = ['<robot name="arm">', '<link name="link0"/>']
    before = np.eye(4)
    for i, ((alpha, a, theta, d), (low, high)) in enumerate(zip(job.dh, job.limits, strict=True), start=1):
        limit = f'<axis xyz="0 0 1"/><limit lower="{low:.17g}" upper="{high:.17g}" effort="1" velocity="1"/>'
        parts.append(
            _joint(f"joint{i}", f"link{i - 1}", f"link{i}", before @ link(alpha, a, 0.0, 0.0), limit)
        )
        before = link(0.0, 0.0, theta, d)
    parts.append(_joint("mount", f"link{len(job.dh)}", FLANGE, before))
    return "\n".join([*parts, "</robot>"])


def _joint(name: str, parent: str, child: str, place: np.ndarray, limit: str = "") -> str:
    """Return a link and the joint that carries it at a place ``(4, 4)`` of its parent; a fixed joint if there is no limit."""
    xyz, rpy = (" ".join(f"{x:.17g}" for x in each) for each in (place[:3, 3], roll_pitch_yaw(place[:3, :3])))
    return (
        f'<link name="{child}"/><joint name="{name}" type="{"revolute" if limit else "fixed"}"><parent link="{parent}"/>'
        f'<child link="{child}"/><origin xyz="{xyz}" rpy="{rpy}"/>{limit}</joint>'
    )


def roll_pitch_yaw(R: np.ndarray) -> np.ndarray:
    """Return the angles ``(3,)`` [rad] of ``R = Rz(yaw) Ry(pitch) Rx(roll)``; a pitch near a right angle is not expected."""
    return np.array([np.arctan2(R[2, 1], R[2, 2]), np.arcsin(-R[2, 0]), np.arctan2(R[1, 0], R[0, 0])])
