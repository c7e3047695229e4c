"""Angles that are the same turn."""

from __future__ import annotations

from typing import Any

import numpy as np


def within_half_turn(angle: Any) -> Any:
    """Return an angle [rad], or an array of them, less the whole turns that bring it between minus and plus half a turn."""
    return np.arctan2(np.sin(angle), np.cos(angle))
