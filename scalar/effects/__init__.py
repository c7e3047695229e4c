"""Effects that a rigid geometric model lacks, a file a place; ``catalogue`` lists them."""

from scalar.effects.effect import BaseEffect, Effect, JointEffect, LinkEffect, PointEffect, SensorEffect

__all__ = ["BaseEffect", "Effect", "JointEffect", "LinkEffect", "PointEffect", "SensorEffect"]
