"""The floor that repeated poses set: how far the measured points of a campaign scatter where the arm came back, without any model."""

from __future__ import annotations

from typing import Any

from scalar.data.dataset import Dataset
from scalar.diagnosis.noise.repeated_poses import repeated_poses
from scalar.units import MM


def floor_of(dataset: Dataset) -> dict[str, Any] | None:
    """Return ``{"scatter_mm", "returns", "poses"}`` of the poses to which the arm came back; None without tracked points or with too few returns.

    ``scatter_mm`` is the root mean square distance of a point from its mean over the returns. It holds the arm's repeatability, the noise of
    the instrument, and what differences of the joint values below ``SAME_ANGLES`` move.
    """
    found = repeated_poses(dataset)
    if found is None:
        return None
    return {"scatter_mm": found.scatter / MM, "returns": found.returns, "poses": found.poses}
