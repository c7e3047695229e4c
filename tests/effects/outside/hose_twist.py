"""An effect of a user's own, in a file outside the package: a hose that twists joint 4."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from scalar.effects import JointEffect, OneJoint


@dataclass(frozen=True, eq=False)
class HoseTwist(OneJoint, JointEffect):
    """The hose along the forearm twists a joint, by how far it and the next one bend it: ``dq_j = c cos(2 q_j) sin(q_j+1)``."""

    joint: int
    name: ClassVar[str] = "hose_twist"
    kind: ClassVar[str] = "twist by the hose"
    sentence: ClassVar[str] = "the hose along the forearm twists the joint"
    coefficient_names = ("twist_rad",)
    coefficient_units = ("rad",)

    def joint_basis(self, robot, poses):
        B = np.zeros((len(poses), robot.n_joints, 1))
        B[:, self.joint - 1, 0] = np.cos(2 * poses.q[:, self.joint - 1]) * np.sin(poses.q[:, self.joint])
        return B

    @classmethod
    def candidates(cls, dataset):
        return [cls(joint) for joint in (3, 4, 5)]
