"""One independent generator for each use of chance, all from one seed.

Changing how much one part draws (more poses, more points) leaves every other part's draws as they were, so a
sweep compares like with like. Planes have generators of their own, by their place in the config.
"""

import numpy as np

(
    POSES,
    INITIAL_MODEL,
    TRUE_ARM,
    PLANE_GUESS,
    RANGE_NOISE,
    SCAN_BIAS,
    JOINT_NOISE,
    SELECTION,
    ORDER,
    EFFECTS,
    WEIGHTS,
    TIME,
    APPROACH,
    TEMPERATURE,
    SCANNER,
    SURFACE,
    PAYLOAD,
) = range(17)
"""The uses of chance. Numbers are part of what a seed means: append, never reorder."""

TRUTH_POSES_SEED = 20180710
"""The one seed of the evaluation poses, whatever the scene's seed: all calibrations are judged alike."""


def stream(seed: int, use: int, plane: int = 0, pose: int | None = None) -> np.random.Generator:
    """Return the generator of one use of chance, for one plane, or for one of its poses, in the order of finding them."""
    key = (use, plane) if pose is None else (use, plane, pose)
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=key))
