"""Effects that a rigid geometric model lacks, a file a kind; ``scalar.effects.registry`` collects them and those of users."""

from scalar.effects.effect import Effect
from scalar.effects.places import BaseEffect, JointEffect, LinkEffect, OneJoint, PointEffect, SensorEffect

__all__ = ["BaseEffect", "Effect", "JointEffect", "LinkEffect", "OneJoint", "PointEffect", "SensorEffect"]
