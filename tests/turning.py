"""Arms of which all joints turn, for tests of functions that ask which joints are prismatic."""

import numpy as np


def turning(n_joints: int) -> np.ndarray:
    """Return which of n joints are prismatic, ``(n,)`` bool: none."""
    return np.zeros(n_joints, dtype=bool)
