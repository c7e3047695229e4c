"""The geometry of an arm as numbers, from which pybullet's arm is made.

T_{i-1,i} = Rx(alpha) Tx(a) Ry(beta) Rz(q + theta) Tz(d), Craig's modified DH with Hayati's beta.
`sensor_frames` repeats pybullet's forward kinematics in NumPy, thousands of postures at a time. It is a fast filter of
candidate poses; every pose that is kept, and every measured number, comes from pybullet.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from scalar.simulation.transforms import (
    Array,
    rotation_from_vector,
    rotation_x,
    rotation_y,
    rotation_z,
    transform,
    vector_from_rotation,
)
from scalar.simulation.weights import Weights

FIELDS = ("a", "alpha", "d", "theta", "beta")
GRAVITY = (0.0, 0.0, -9.81)  # m/s^2, the dataset format's default


@dataclass(frozen=True, eq=False)
class Arm:
    """A serial arm of n revolute joints with a sensor on its flange.

    Attributes:
        name: name of the robot.
        a, d: (n,) [m].
        alpha, theta, beta: (n,) [rad].
        limits: (n, 2) [rad].
        T_base_0, T_n_flange, T_flange_sensor: (4, 4).
        gravity: (3,) [m/s^2] in the base frame.
        weights: masses and centres of mass of its links; None where nothing depends on them.
    """

    name: str
    a: Array
    alpha: Array
    d: Array
    theta: Array
    beta: Array
    limits: Array
    T_base_0: Array
    T_n_flange: Array
    T_flange_sensor: Array
    gravity: Array
    weights: Weights | None = None

    @property
    def n(self) -> int:
        """Return the number of joints."""
        return len(self.a)

    def joint_origin(self, i: int) -> Array:
        """Return T_{i,i+1} at q = 0, (4, 4), for the joint of index `i` from 0.

        Rz(q) commutes with Tz(d), so the joint is this fixed transform followed by a rotation q about its z axis.
        """
        R = rotation_x(self.alpha[i])
        R_out = R @ rotation_y(self.beta[i]) @ rotation_z(self.theta[i])
        return transform(R_out, R @ [self.a[i], 0.0, 0.0] + R_out @ [0.0, 0.0, self.d[i]])

    def sensor_frames(self, q: Array) -> tuple[Array, Array]:
        """Return the sensor's R (N, 3, 3) and origin (N, 3) [m] in the base frame, for q (N, n) [rad]."""
        R = np.broadcast_to(self.T_base_0[:3, :3], (len(q), 3, 3))
        p = np.broadcast_to(self.T_base_0[:3, 3], (len(q), 3))
        for i in range(self.n):
            T = self.joint_origin(i)
            p = p + R @ T[:3, 3]
            R = R @ T[:3, :3]
            c, s = np.cos(q[:, i, None]), np.sin(q[:, i, None])
            x, y = R[..., 0], R[..., 1]
            R = np.stack([c * x + s * y, c * y - s * x, R[..., 2]], -1)
        T = self.T_n_flange @ self.T_flange_sensor
        return R @ T[:3, :3], p + R @ T[:3, 3]

    def shifted(self, errors: Mapping[str, Array]) -> "Arm":
        """Return the arm with errors added: `FIELDS` (n,), and `t` (3,) [m] and `r` (3,) [rad] of the sensor.

        The sensor's rotation error is a rotation vector in the sensor's own frame: R Exp(r).
        """
        fields = {name: getattr(self, name) + errors[name] for name in FIELDS if name in errors}
        T = self.T_flange_sensor.copy()
        T[:3, 3] += errors.get("t", np.zeros(3))
        T[:3, :3] = T[:3, :3] @ rotation_from_vector(errors.get("r", np.zeros(3)))
        return replace(self, **fields, T_flange_sensor=T)


def pose_matrix(pose: Mapping[str, Any] | None) -> Array:
    """Return T (4, 4) of a mapping `{translation: [m], rotation_vector: [rad]}`; the identity for None."""
    if pose is None:
        return np.eye(4)
    vector = np.array(pose.get("rotation_vector", (0, 0, 0)), float)
    return transform(rotation_from_vector(vector), np.array(pose.get("translation", (0, 0, 0)), float))


def pose_mapping(T: Array) -> dict[str, list[float]]:
    """Return `{translation, rotation_vector}` of T (4, 4)."""
    return {"translation": T[:3, 3].tolist(), "rotation_vector": vector_from_rotation(T[:3, :3]).tolist()}


def arm_from_mapping(robot: Mapping[str, Any], sensor_pose: Mapping[str, Any] | None) -> Arm:
    """Return the arm of the `robot:` block of a dataset.yaml, its sensor at `sensor_pose` on the flange.

    Standard DH, Rz(q + theta) Tz(d) Tx(a) Rx(alpha), becomes modified DH by moving each a and alpha to the next joint
    outwards; the last pair goes into the flange transform. Joints without limits get +-pi.
    """
    joints = robot["joints"]
    values = {name: np.array([float(joint.get(name, 0.0)) for joint in joints]) for name in FIELDS}
    T_n_flange = pose_matrix(robot.get("flange"))
    if robot["convention"] == "standard-dh":
        T_last = transform(rotation_x(values["alpha"][-1]), np.array([values["a"][-1], 0.0, 0.0]))
        T_n_flange = T_last @ T_n_flange
        for name in ("a", "alpha"):
            values[name] = np.concatenate([[0.0], values[name][:-1]])
    return Arm(
        name=robot["name"],
        **values,
        limits=np.array([joint.get("limits", (-np.pi, np.pi)) for joint in joints], float),
        T_base_0=pose_matrix(robot.get("base")),
        T_n_flange=T_n_flange,
        T_flange_sensor=pose_matrix(sensor_pose),
        gravity=np.array(robot.get("gravity", GRAVITY), float),
        weights=None,
    )


def arm_mapping(arm: Arm) -> dict[str, Any]:
    """Return the `robot:` block of a dataset.yaml: what the user is told about the arm."""
    joints = []
    for i in range(arm.n):
        joint: dict[str, Any] = {name: float(getattr(arm, name)[i]) for name in ("a", "alpha", "d", "theta")}
        if arm.beta[i] != 0.0:
            joint["beta"] = float(arm.beta[i])
        joints.append(joint | {"limits": arm.limits[i].tolist()})
    mapping: dict[str, Any] = {"name": arm.name, "convention": "modified-dh", "joints": joints}
    if not np.array_equal(arm.T_base_0, np.eye(4)):
        mapping["base"] = pose_mapping(arm.T_base_0)
    if not np.array_equal(arm.T_n_flange, np.eye(4)):
        mapping["flange"] = pose_mapping(arm.T_n_flange)
    return mapping | {"gravity": arm.gravity.tolist()}
