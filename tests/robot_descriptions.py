"""Robot descriptions for tests: those that pybullet ships, random ones, and where pybullet itself puts their links."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np

ARMS = {
    "iiwa": ("kuka_iiwa/model.urdf", "lbr_iiwa_link_0", "lbr_iiwa_link_7"),
    "panda": ("franka_panda/panda.urdf", "panda_link0", "panda_hand"),
    "xarm6": ("xarm/xarm6_robot.urdf", "link_base", "link6"),
    "xarm6 with gripper": ("xarm/xarm6_with_gripper.urdf", None, "xarm_gripper_base_link"),
    "r2d2's head": ("r2d2.urdf", "base_link", "box"),  # no arm: an axis across, and a fixed joint
    "a1's leg": ("a1/a1.urdf", "trunk", "FR_lower"),
    "laikago's leg": ("laikago/laikago_toes_zup.urdf", "chassis", "toeRL"),
    # With joints that slide:
    "panda and a finger": ("franka_panda/panda.urdf", "panda_link0", "panda_leftfinger"),
    "r2d2's gripper": ("r2d2.urdf", "base_link", "left_tip"),
    "cart with a pole": ("cartpole.urdf", "slideBar", "pole"),
}
"""File among those that pybullet ships, base and tip."""


def shipped(name: str) -> Path:
    """Return the path of a file that pybullet ships."""
    import pybullet_data

    return Path(pybullet_data.getDataPath()) / ARMS[name][0]


def kinematics_alone(path: Path, copy: Path) -> Path:
    """Write a copy without bodies: link frames then are centres of mass, which are what pybullet states in double precision."""
    tree = ElementTree.parse(path)
    for link in tree.getroot().iter("link"):
        for child in list(link):
            link.remove(child)
    tree.write(copy)
    return copy


def poses_by_pybullet(path: Path, base: str, tip: str, q: np.ndarray, joints: list[str]) -> np.ndarray:
    """Return where pybullet puts the tip in the base's frame, ``(N, 4, 4)``, at angles ``(N, n)`` of named joints; the file has no bodies."""
    import pybullet

    client = pybullet.connect(pybullet.DIRECT)
    try:
        body = pybullet.loadURDF(str(path), useFixedBase=True, physicsClientId=client)
        infos = [
            pybullet.getJointInfo(body, k, physicsClientId=client)
            for k in range(pybullet.getNumJoints(body, physicsClientId=client))
        ]
        index_of = {info[1].decode(): info[0] for info in infos}
        link_of = {info[12].decode(): info[0] for info in infos}

        def frame(link: str) -> np.ndarray:
            if link not in link_of:
                position, turn = pybullet.getBasePositionAndOrientation(body, physicsClientId=client)
            else:
                position, turn = pybullet.getLinkState(
                    body, link_of[link], computeForwardKinematics=True, physicsClientId=client
                )[:2]
            T = np.eye(4)
            T[:3, :3] = _rotation(turn)
            T[:3, 3] = position
            return T

        found = []
        for angles in q:
            for name, angle in zip(joints, angles, strict=True):
                pybullet.resetJointState(body, index_of[name], float(angle), physicsClientId=client)
            found.append(np.linalg.inv(frame(base)) @ frame(tip))
        return np.array(found)
    finally:
        pybullet.disconnect(client)


def _rotation(quaternion: tuple[float, float, float, float]) -> np.ndarray:
    from scipy.spatial.transform import Rotation

    return Rotation.from_quat(quaternion).as_matrix()


def random_description(rng: np.random.Generator, n: int) -> str:
    """Return a chain of n joints about any axes, some (nearly) parallel or meeting, with fixed joints between; links l0 to tip, and aside."""
    lines, k = ['<robot name="random">', '<link name="l0"/>'], 0

    def joint(kind: str, xyz: np.ndarray, rpy: np.ndarray, axis: np.ndarray) -> None:
        nonlocal k
        k += 1
        numbers = [" ".join(f"{x:.17g}" for x in v) for v in (xyz, rpy, axis)]
        lines.append(
            f'<link name="l{k}"/><joint name="j{k}" type="{kind}"><parent link="l{k - 1}"/><child link="l{k}"/>'
            f'<origin xyz="{numbers[0]}" rpy="{numbers[1]}"/><axis xyz="{numbers[2]}"/>'
            '<limit lower="-3" upper="3" effort="1" velocity="1"/></joint>'
        )

    for _ in range(n):
        xyz = rng.uniform(-0.5, 0.5, 3) * (rng.random(3) < 0.7)
        turns = [rng.uniform(-3, 3, 3), np.round(rng.uniform(-2, 2, 3)) * np.pi / 2, np.zeros(3)]
        rpy = turns[rng.integers(3)] + rng.choice([0.0, 1e-13, 1e-7, 3e-3]) * rng.normal(size=3)
        axes = [rng.normal(size=3), np.eye(3)[rng.integers(3)] * rng.choice([-1.0, 1.0])]
        axis = axes[
            rng.integers(2)
        ]  # of unit length, as the format has it: pybullet slides by q times its length
        kind = str(rng.choice(["revolute", "continuous", "prismatic"]))
        joint(kind, xyz, rpy, axis / np.linalg.norm(axis))
        if rng.random() < 0.4:
            joint("fixed", rng.uniform(-0.2, 0.2, 3), rng.uniform(-3, 3, 3), np.array([1.0, 0, 0]))
    lines.append(
        '<link name="aside"/><joint name="ja" type="fixed"><parent link="l0"/><child link="aside"/>'
        '<origin xyz="0.1 0.2 -0.3" rpy="0.5 -0.2 3.1"/></joint>'
    )
    return "\n".join([*lines, "</robot>"]).replace(f'"l{k}"', '"tip"')
