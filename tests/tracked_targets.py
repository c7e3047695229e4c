"""An arm with several targets on its flange before a tracker: that of the tracked trials."""

import numpy as np
from study.tracked_trials.tracked_arm import GUESS, TrackedArm, relative

__all__ = ["GUESS", "TrackedArm", "drawn_arm", "relative"]


def drawn_arm(rng: np.random.Generator, targets: tuple[str, ...], sessions: int = 1) -> TrackedArm:
    """Return a small arm of six joints with targets on its flange, whose true geometry is drawn."""
    return TrackedArm.drawn(rng, targets, "vs060", sessions)
