"""A serial chain of revolute and prismatic joints in complete modified Denavit-Hartenberg parameters, and the screw of each parameter.

``T_{i-1,i} = Rx(alpha_i) Tx(a_i) Ry(beta_i) Rz(q_i + theta_i) Tz(d_i)`` (Craig, with Hayati's beta for near-parallel axes),
between a fixed transform before the first joint and one after the last. A prismatic joint slides by q along its z axis:
``Rz(theta_i) Tz(q_i + d_i)``, q in metres. Links are assumed to be rigid; compliance and drift enter as offsets to ``q`` and to the
geometry, different at each pose (see ``scalar.effects``).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from scalar import kernels
from scalar.geometry.se3 import Array, log_so3, transform_from_rotation_vector

BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.intp]

GEOMETRY = ("a", "alpha", "d", "theta", "beta")
"""Kinds of geometric parameter, in the order of the rows of ``Robot.geometry``."""
LENGTHS = frozenset({"a", "d"})
_A, _D, _THETA = GEOMETRY.index("a"), GEOMETRY.index("d"), GEOMETRY.index("theta")
_ANGLES = [GEOMETRY.index(kind) for kind in ("alpha", "theta", "beta")]

STANDARD_GRAVITY = (0.0, 0.0, -9.81)  # m/s^2, base frame; for a dataset that states none
DEFAULT_LIMIT = np.pi  # rad, on either side of zero, for a revolute joint without stated limits
DEFAULT_TRAVEL = 1.0  # m, the same for a prismatic joint


@dataclass(frozen=True)
class Tolerance:
    """How far an arm may differ from its data sheet according to its maker, as standard deviations.

    Attributes:
        length: Standard deviation of every length [m].
        angle: Standard deviation of every angle and joint zero [rad].
    """

    length: float
    angle: float


@dataclass(frozen=True, eq=False)
class Robot:
    """A chain of n revolute or prismatic joints: what a maker's data sheet says, or what a calibration found.

    Attributes:
        name: Name of the arm.
        geometry: ``(5, n)``, rows as in ``GEOMETRY``: a [m], alpha [rad], d [m], theta [rad], beta [rad].
        limits: ``(n, 2)`` [rad; m for a prismatic joint], lowest and highest joint angle or travel.
        T_base_0: ``(4, 4)``, fixed transform before the first joint.
        T_n_flange: ``(4, 4)``, fixed transform after the last joint.
        gravity: ``(3,)`` [m/s^2] in the base frame.
        tolerance: The maker's, where it is stated.
        standard_end: a [m] and alpha [rad] of the last link, which are part of ``T_n_flange``, if the arm was read from a standard-DH table;
            None if it was read from modified DH. ``geometry`` is modified DH in both cases.
        prismatic: Indices, from 0 and ascending, of the joints that slide instead of turning.

    Example:
        An arm of two links, stretched out:

        >>> import numpy as np
        >>> from scalar import Robot
        >>> joints = [{"a": a, "alpha": 0.0, "d": 0.0, "theta": 0.0} for a in (0.0, 0.4)]
        >>> robot = Robot.from_mapping({"name": "two links", "joints": joints})
        >>> T_base_flange = robot.flange(np.array([[np.pi / 2, 0.0]]))
        >>> T_base_flange[0, :3, 3].round(12).tolist()
        [0.0, 0.4, 0.0]
    """

    name: str
    geometry: Array
    limits: Array
    T_base_0: Array
    T_n_flange: Array
    gravity: Array
    tolerance: Tolerance | None = None
    standard_end: tuple[float, float] | None = None
    prismatic: tuple[int, ...] = ()

    @property
    def standard_dh(self) -> bool:
        """Return whether the arm was read from a standard-DH table."""
        return self.standard_end is not None

    @property
    def slides(self) -> BoolArray:
        """Return which joints are prismatic, ``(n,)``."""
        return np.isin(np.arange(self.n_joints), self.prismatic)

    @property
    def turning(self) -> list[int]:
        """Return the joints that turn, from 1; all others slide."""
        return [j + 1 for j in range(self.n_joints) if j not in self.prismatic]

    @property
    def joint_columns(self) -> slice | IntArray:
        """Return the indices, in ``geometry.ravel()``, of the n parameters that move the arm as q does: theta, or d of a prismatic joint."""
        n = self.n_joints
        if not self.prismatic:
            return slice(_THETA * n, (_THETA + 1) * n)
        return np.where(self.slides, _D, _THETA) * n + np.arange(n)

    @property
    def down(self) -> Array:
        """Return the direction of gravity ``(3,)`` in the base frame, of unit length; zero where there is none."""
        return self.gravity / max(float(np.linalg.norm(self.gravity)), 1e-12)

    @property
    def n_joints(self) -> int:
        """Return the number of joints."""
        return self.geometry.shape[1]

    @property
    def parameter_names(self) -> list[str]:
        """Return ``a_1 .. a_n alpha_1 .. beta_n``, in the order of ``geometry.ravel()``."""
        return [f"{kind}_{i + 1}" for kind in GEOMETRY for i in range(self.n_joints)]

    def with_geometry(self, geometry: Array) -> Robot:
        """Return the same arm with another geometry ``(5, n)``."""
        return replace(self, geometry=np.array(geometry, dtype=float))

    @classmethod
    def from_mapping(cls, mapping: Mapping[str, Any]) -> Robot:
        """Return the robot of the ``robot:`` block of a dataset (already checked against its schema).

        Standard DH, ``Rz(q + theta) Tz(d) Tx(a) Rx(alpha)``, becomes modified DH by shifting every link's a and alpha
        to the next joint; the last pair goes into the flange's transform.

        Raises:
            ValueError: A standard-DH table has a beta.
        """
        joints = mapping["joints"]
        n = len(joints)
        geometry = np.array([[float(joint.get(kind, 0.0)) for joint in joints] for kind in GEOMETRY])
        flange = _fixed_transform(mapping.get("flange"))
        end = None
        if mapping.get("convention", "modified-dh") == "standard-dh":
            if geometry[4].any():
                raise ValueError("beta belongs to modified DH; a standard-DH chain has no such parameter")
            a, alpha = geometry[0].copy(), geometry[1].copy()
            geometry[0], geometry[1] = np.r_[0.0, a[:-1]], np.r_[0.0, alpha[:-1]]
            end = float(a[-1]), float(alpha[-1])
            flange = link_end(*end) @ flange
        prismatic = tuple(i for i, joint in enumerate(joints) if joint.get("type") == "prismatic")
        largest = [DEFAULT_TRAVEL if i in prismatic else DEFAULT_LIMIT for i in range(n)]
        limits = np.array(
            [joint.get("limits", [-largest[i], largest[i]]) for i, joint in enumerate(joints)], dtype=float
        )
        return cls(
            name=str(mapping["name"]),
            geometry=geometry,
            limits=limits.reshape(n, 2),
            T_base_0=_fixed_transform(mapping.get("base")),
            T_n_flange=flange,
            gravity=np.array(mapping.get("gravity", STANDARD_GRAVITY), dtype=float),
            tolerance=_tolerance(mapping.get("tolerance")),
            standard_end=end,
            prismatic=prismatic,
        )

    def to_mapping(self) -> dict[str, Any]:
        """Return the ``robot:`` block of a dataset, in modified DH (``standard_dh.stated_mapping`` writes it in the convention that was read)."""
        joints: list[dict[str, Any]] = []
        for i in range(self.n_joints):
            joint: dict[str, Any] = {kind: float(self.geometry[k, i]) for k, kind in enumerate(GEOMETRY)}
            joint["limits"] = [float(x) for x in self.limits[i]]
            if i in self.prismatic:
                joint["type"] = "prismatic"
            joints.append(joint)
        return {
            "name": self.name,
            "convention": "modified-dh",
            "joints": joints,
            "base": fixed_transform_mapping(self.T_base_0),
            "flange": fixed_transform_mapping(self.T_n_flange),
            "gravity": [float(x) for x in self.gravity],
            **({} if self.tolerance is None else {"tolerance": asdict(self.tolerance)}),
        }

    def frames(self, q: Array, geometry_offsets: Array | None = None) -> Array:
        """Return the frames 0..n of every pose in the base frame.

        Args:
            q: ``(N, n)`` [rad; m for prismatic joints], joint angles and travels.
            geometry_offsets: ``(N, 5, n)``, added to the geometry pose by pose, or None.

        Returns:
            ``(N, n + 1, 4, 4)``, ``T_base_i``; the last is the frame of the last joint, before the flange's transform.
        """
        geometry = self.geometry if geometry_offsets is None else self.geometry + geometry_offsets
        if not self.prismatic:
            compiled = kernels.frames(q, geometry, self.T_base_0)
            if compiled is not None:
                return compiled
        T_links = self.links(geometry, q)
        frames = np.empty((q.shape[0], self.n_joints + 1, 4, 4))
        frames[:, 0] = self.T_base_0
        for i in range(self.n_joints):
            np.matmul(frames[:, i], T_links[:, i], out=frames[:, i + 1])
        return frames

    def links(self, geometry: Array, q: Array) -> Array:
        """Return the transform of every link ``(N, n, 4, 4)`` with a geometry ``(5, n)`` or ``(N, 5, n)``, at ``q`` as in ``frames``."""
        if self.prismatic:
            where = list(self.prismatic)
            geometry = np.broadcast_to(geometry, (len(q), *self.geometry.shape)).copy()
            geometry[:, _D, where] += q[:, where]
            q = np.where(self.slides, 0.0, q)
        return link_transforms(geometry, q)

    def flange(self, q: Array) -> Array:
        """Return ``T_base_flange`` ``(N, 4, 4)`` at joint angles and travels ``q`` ``(N, n)`` [rad, m]."""
        return self.frames(q)[:, -1] @ self.T_n_flange

    def screws(self, frames: Array, geometry_offsets: Array | None = None, further: int = 0) -> Array:
        """Return the screw of every geometric parameter in the base frame, ``(N, 6, 5 n + further)``.

        The columns are in the order of ``parameter_names``. a and d translate along an axis of a frame; alpha, beta and theta
        rotate about an axis of a frame. A joint angle q_i has the screw of theta_i, and the travel of a prismatic joint that of d_i
        (see ``joint_columns``).

        Args:
            frames: ``(N, n + 1, 4, 4)`` from ``frames``, with the same offsets.
            geometry_offsets: As in ``frames``.
            further: Number of columns of zeros that follow, for other parameters.
        """
        n = self.n_joints
        geometry = self.geometry if geometry_offsets is None else self.geometry + geometry_offsets
        found = np.zeros((len(frames), 6, 5 * n + further))
        if kernels.screws(frames, geometry, found):
            return found
        columns = np.swapaxes(frames, 1, 3)  # (N, axes and origin, their coordinates, frames)
        before, after = columns[..., :-1], columns[..., 1:]
        a, alpha = (np.expand_dims(geometry[..., k, :], -2) for k in (0, 1))
        x_before, z_after, o_before = (
            at.copy() for at in (before[:, 0, :3], after[:, 2, :3], before[:, 3, :3])
        )
        y_tilted = np.cos(alpha) * before[:, 1, :3] + np.sin(alpha) * before[:, 2, :3]
        screws = np.zeros((len(frames), 6, 5, n))
        screws[:, 3:, _A], screws[:, 3:, _D] = x_before, z_after
        points = o_before, after[:, 3, :3], o_before + a * x_before
        for k, axis, point in zip(_ANGLES, (x_before, z_after, y_tilted), points, strict=True):
            screws[:, :3, k] = axis
            for row, i, j in ((3, 1, 2), (4, 2, 0), (5, 0, 1)):  # the cross product
                screws[:, row, k] = point[:, i] * axis[:, j] - point[:, j] * axis[:, i]
        found[:, :, : 5 * n] = screws.reshape(len(frames), 6, 5 * n)
        return found


def link_end(a: float, alpha: float) -> Array:
    """Return ``Tx(a) Rx(alpha)`` ``(4, 4)``, with which a link ends in standard DH; a [m], alpha [rad]."""
    return transform_from_rotation_vector([a, 0.0, 0.0], [alpha, 0.0, 0.0])


def link_transforms(geometry: Array, q: Array) -> Array:
    """Return ``Rx(alpha) Tx(a) Ry(beta) Rz(q + theta) Tz(d)`` of every revolute joint, ``(N, n, 4, 4)``.

    Args:
        geometry: ``(5, n)`` or ``(N, 5, n)``.
        q: ``(N, n)`` [rad].
    """
    a, alpha, d, theta, beta = (geometry[..., k, :] for k in range(5))
    c_alpha, s_alpha, c_beta, s_beta = np.cos(alpha), np.sin(alpha), np.cos(beta), np.sin(beta)
    c, s = np.cos(q + theta), np.sin(q + theta)
    T = np.zeros((*q.shape, 4, 4))
    T[..., 0, 0], T[..., 0, 1], T[..., 0, 2] = c_beta * c, -c_beta * s, s_beta
    T[..., 1, 0], T[..., 1, 1] = s_alpha * s_beta * c + c_alpha * s, c_alpha * c - s_alpha * s_beta * s
    T[..., 2, 0], T[..., 2, 1] = s_alpha * s - c_alpha * s_beta * c, c_alpha * s_beta * s + s_alpha * c
    T[..., 1, 2], T[..., 2, 2] = -s_alpha * c_beta, c_alpha * c_beta
    T[..., :3, 3] = T[..., :3, 2] * np.asarray(d)[..., None]
    T[..., 0, 3] += a
    T[..., 3, 3] = 1.0
    return T


def _tolerance(mapping: Mapping[str, Any] | None) -> Tolerance | None:
    return None if mapping is None else Tolerance(float(mapping["length"]), float(mapping["angle"]))


def _fixed_transform(mapping: Mapping[str, Any] | None) -> Array:
    if not mapping:
        return np.eye(4)
    return transform_from_rotation_vector(
        mapping.get("translation", [0.0, 0.0, 0.0]), mapping.get("rotation_vector", [0.0, 0.0, 0.0])
    )


def fixed_transform_mapping(T: Array) -> dict[str, list[float]]:
    """Return ``{translation [m], rotation_vector [rad]}`` of a transform ``(4, 4)``, as datasets write it."""
    return {
        "translation": [float(x) for x in T[:3, 3]],
        "rotation_vector": [float(x) for x in log_so3(T[:3, :3])],
    }
