"""A gas spring between the carousel and the forearm, which bends a drive of joint 2 or 3: an error of one joint over the angles of both."""

from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np

from scalar.simulation.injected.causes.base import scaled
from scalar.simulation.injected.causes.drives import DriveCause
from scalar.simulation.injected.stage import Stage
from scalar.simulation.transforms import Array
from scalar.simulation.world import World

JOINTS = (2, 3)  # shoulder and elbow
# Lengths are counted in lengths of the upper arm: the anchor's distance from the shoulder, and the mount's from the elbow, on the forearm.
ANCHOR, MOUNT = (0.4, 0.9), (0.3, 0.8)
NEUTRAL = (0.2, 0.8)  # the spring pushes below this quantile of its lengths in the scene, and pulls above it


@dataclass(frozen=True, eq=False)
class ForearmSpring(DriveCause):
    """A spring from an anchor on the carousel to a mount on the forearm; the drive of one joint yields to its torque.

    In the plane of the arm, with the shoulder at the origin, the elbow is at e = (cos q2, sin q2), and the mount at
    p = e + m (cos(q2 + q3), sin(q2 + q3)). The spring has the length L = |p - c| from its anchor c and the force L - L0 along (c - p) / L. Its
    torque about joint 2 is that of this force about the shoulder, and about joint 3 about the elbow; the joint errs in proportion to it.
    """

    kind: ClassVar[str] = "forearm_spring"

    @classmethod
    def needs(cls, entry: Any) -> set[str]:
        """Return nothing: it depends on the angles alone."""
        return set()

    @classmethod
    def drawn(cls, target: dict[str, Any], size: float, stage: Stage, rng: np.random.Generator) -> Self:
        """Draw the joint, the anchor, the mount and the neutral length."""
        joint = target.get("joint", int(rng.choice(JOINTS)))
        if joint not in JOINTS:
            stage.refuse(
                "target.joint", f"a spring of the forearm loads the joints {JOINTS[0]} and {JOINTS[1]}"
            )
        turn, distance = rng.uniform(0.0, 2 * np.pi), rng.uniform(*ANCHOR)
        anchor = [float(distance * np.cos(turn)), float(distance * np.sin(turn))]
        mount = float(rng.uniform(*MOUNT))
        _, place = _plane(stage.q, mount)
        neutral = float(np.quantile(np.linalg.norm(place - anchor, axis=1), rng.uniform(*NEUTRAL)))
        unscaled = cls(
            {"joint": joint},
            size,
            cls.details_of(["q2", "q3"], anchor=anchor, mount=mount, neutral=neutral, factor=1.0),
        )
        _, factor = scaled(unscaled.torque(stage.q, joint), size)
        return cls({"joint": joint}, size, unscaled.details | {"factor": factor})

    def raw(self, world: World, q: Array, j: int) -> Array:
        """Return the torque of the spring about the joint with index j, from 0 (N,)."""
        return self.torque(q, j + 1)

    def torque(self, q: Array, joint: int) -> Array:
        """Return the torque of the spring about joint 2 or 3 (N,), in units of its stiffness and the upper arm's length; q (N, n) [rad]."""
        anchor = np.array(self.details["anchor"])
        elbow, place = _plane(q, self.details["mount"])
        along = anchor - place
        length = np.linalg.norm(along, axis=1)
        force = ((length - self.details["neutral"]) / length)[:, None] * along
        lever = place if joint == JOINTS[0] else place - elbow
        return lever[:, 0] * force[:, 1] - lever[:, 1] * force[:, 0]


def _plane(q: Array, mount: float) -> tuple[Array, Array]:
    """Return elbow and mount (N, 2) in the plane of the arm, in lengths of the upper arm, at joint angles (N, n) [rad]."""
    elbow = np.column_stack([np.cos(q[:, 1]), np.sin(q[:, 1])])
    both = q[:, 1] + q[:, 2]
    return elbow, elbow + mount * np.column_stack([np.cos(both), np.sin(both)])
