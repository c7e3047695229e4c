"""What an effect is given when it is injected: the workcell and its poses without any effect.

From these the effect draws what its entry in the config leaves open: an influential joint, a moment in the middle of the run, the
scanned part of a target plane.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NoReturn

import numpy as np
import pandas as pd

from scalar.errors import Fault, InvalidInput
from scalar.simulation.arm import Arm
from scalar.simulation.plan import Workcell
from scalar.simulation.scanner import directions
from scalar.simulation.target_planes import TargetPlane
from scalar.simulation.transforms import Array
from scalar.simulation.world import World

# A joint is influential if it moves the laser's points by at least this share of the motion that the most influential joint causes.
INFLUENTIAL = 0.1
LOADED = 0.05  # a joint carries weight if its torque is at least this share of the largest
STEP = 1e-5  # rad; step of central differences
MIDDLE = (0.25, 0.75)  # part of the run from which a moment is drawn


@dataclass(frozen=True, eq=False)
class Stage:
    """The workcell without effects, its poses, and the place of the effect in the config.

    Attributes:
        workcell: without effects.
        poses: table of poses in acquisition order, with all recorded columns.
        plane_index: (N,), index of the target plane of each pose.
        index: place of the effect's entry in the list `injected`, from 0.
    """

    workcell: Workcell
    poses: pd.DataFrame
    plane_index: Array
    index: int

    @property
    def arm(self) -> Arm:
        """Return the arm without effects."""
        return self.workcell.arm

    @cached_property
    def q(self) -> Array:
        """Return the joint angles of the poses (N, n) [rad]."""
        return self.poses[[f"q{i + 1}" for i in range(self.arm.n)]].to_numpy()

    @cached_property
    def torques(self) -> Array:
        """Return the torque of the weight about each joint (N, n) [N m]."""
        with World() as world:
            world.place_arm(self.arm)
            return world.gravity_torques(self.q)

    @cached_property
    def loaded(self) -> list[int]:
        """Return the joints, from 1, that carry weight."""
        largest = np.abs(self.torques).max(0)
        return [j + 1 for j in range(self.arm.n) if largest[j] >= LOADED * largest.max()]

    @cached_property
    def influential(self) -> list[int]:
        """Return the influential joints, from 1; only motion along the normals of the target planes counts."""
        normals = np.array([target_plane.normal for target_plane in self.workcell.target_planes])[
            self.plane_index
        ]
        spots = self._spots(np.array([-1.0, 0.0, 1.0]) * self.workcell.scanner.fan)
        leverage = np.empty(self.arm.n)
        for j in range(self.arm.n):
            step = np.zeros(self.arm.n)
            step[j] = STEP
            (R1, p1), (R0, p0) = self.arm.sensor_frames(self.q + step), self.arm.sensor_frames(self.q - step)
            moved = np.einsum("nij,nmj->nmi", R1 - R0, spots) + (p1 - p0)[:, None]
            per_radian = np.einsum("nmi,ni->nm", moved, normals) / (2 * STEP)
            leverage[j] = np.sqrt((per_radian**2).mean(0).max())
        return [j + 1 for j in range(self.arm.n) if leverage[j] >= INFLUENTIAL * leverage.max()]

    def _spots(self, angles: Array) -> Array:
        """Return where rays at these angles (M,) [rad] end, (N, M, 3) [m] in the sensor's frame."""
        R, origin = self.arm.sensor_frames(self.q)
        normals = np.array([target_plane.normal for target_plane in self.workcell.target_planes])[
            self.plane_index
        ]
        distances = np.array([target_plane.distance for target_plane in self.workcell.target_planes])[
            self.plane_index
        ]
        u = directions(angles)
        height = distances - np.einsum("ni,ni->n", normals, origin)
        toward = np.einsum("nij,mj,ni->nm", R, u, normals)
        return (height[:, None] / toward)[..., None] * u

    def scanned(self, target_plane: TargetPlane) -> tuple[Array, float]:
        """Return the middle of the scanned part of a target plane (2,) [m], on its axes u, v from its centre, and the radius of that part [m].

        The radius extends to the farthest middle of a scan.
        """
        on_it = self.plane_index == self.workcell.target_planes.index(target_plane)
        R, origin = self.arm.sensor_frames(self.q)
        points = origin + np.einsum("nij,nj->ni", R, self._spots(np.zeros(1))[:, 0])
        uv = ((points - target_plane.centre) @ target_plane.axes[:, :2])[on_it]
        middle = (uv.min(0) + uv.max(0)) / 2
        return middle, float(np.linalg.norm(uv - middle, axis=1).max())

    def draw_moment(self, rng: np.random.Generator, rows: Array) -> int:
        """Return one of `rows` (poses in acquisition order), drawn from their middle part."""
        low, high = (round(share * len(rows)) for share in MIDDLE)
        return int(rows[int(rng.integers(low, max(high, low + 1)))])

    def at(self, order: int) -> dict[str, Any]:
        """Return the moment of the pose with this acquisition order: `{order, time}`, time [s], or None if it is not recorded."""
        time = float(self.poses["time"].iloc[order]) if "time" in self.poses else None
        return {"order": order, "time": time}

    def draw_joint(
        self, rng: np.random.Generator, joints: Sequence[int] | None = None, lack: str = ""
    ) -> int:
        """Return a joint, from 1, drawn from `joints`, or from the influential ones if None.

        Raises:
            InvalidInput: `joints` is empty; the message is `lack`.
        """
        joints = self.influential if joints is None else joints
        if not joints:
            self.refuse("target", lack)
        return int(rng.choice(joints))

    def refuse(self, key: str, message: str) -> NoReturn:
        """Raise InvalidInput about a key of this entry."""
        raise InvalidInput([Fault("config", message, column=f"injected[{self.index}].{key}")])
