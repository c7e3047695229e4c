"""An arm with several targets on its flange before a tracker: that of the tracked trials."""

from study.tracked_trials.tracked_arm import GUESS, TrackedArm, relative

__all__ = ["GUESS", "TrackedArm", "relative"]
