"""One independent random generator for each purpose, all from one seed.

If one part draws more numbers (for more poses or more points), the draws of all other parts stay the same, so a
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
"""The purposes. Their numbers are part of what a seed means: append, never reorder."""

TRUTH_POSES_SEED = 20180710
"""The one seed of the evaluation poses, whatever the scene's seed: all calibrations are judged alike."""


def stream(seed: int, use: int, plane: int = 0, pose: int | None = None) -> np.random.Generator:
    """Return the generator of one purpose, for one plane or for one pose of a plane.

    Args:
        seed: the seed of the scene.
        use: the purpose, one of the constants of this module.
        plane: index of the plane in the config, or of the injected effect, from 0.
        pose: index of the pose on its plane, in the order in which poses are found; None for a generator of the whole plane.
    """
    key = (use, plane) if pose is None else (use, plane, pose)
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=key))
