"""Effects that a rigid geometric model lacks, one file for each kind; ``scalar.effects.registry`` lists them, together with those of users."""

from scalar.effects.effect import Effect
from scalar.effects.places import (
    BaseEffect,
    JointEffect,
    LinkEffect,
    OneJoint,
    PointEffect,
    SensorEffect,
    SingleJointEffect,
)

__all__ = [
    "BaseEffect",
    "Effect",
    "JointEffect",
    "LinkEffect",
    "OneJoint",
    "PointEffect",
    "SensorEffect",
    "SingleJointEffect",
]
