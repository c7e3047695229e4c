"""Random poses within the joint limits, at which models of one arm are compared; with the same arguments they are always the same."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from scalar.data.formats import PAYLOAD, TORQUE
from scalar.data.poses import Poses
from scalar.estimation.model import Model
from scalar.geometry.se3 import Array

_SEED = 0
_MOST_KEPT = 16  # sets of poses that are kept, of some 10 kB each
_UNBOUNDED = 4 * np.pi  # rad: a joint whose limit lies beyond two turns counts as unlimited
_TEMPERATURE = (10.0, 30.0)  # deg C: the range in a workshop
_TORQUE, _PAYLOAD = 100.0, 5.0  # N m and kg: largest ones, of an arm that carries some 10 kg
RECORDS_IN_WORDS = f"torques of up to {_TORQUE:g} N m and payloads of up to {_PAYLOAD:g} kg"
"""What ``random_poses`` assumes of columns that only a measured pose has."""


def random_poses(model: Model, count: int) -> Poses:
    """Return poses with uniform joint angles, and with columns that effects may need: directions of approach, a temperature, torques, a payload.

    Args:
        model: The model of the arm; only its nominal limits are used.
        count: How many.
    """
    rng = np.random.default_rng(_SEED)
    q = _joints(model, count, rng)
    columns = {"approach": rng.choice([-1.0, 1.0], q.shape), "temperature": rng.uniform(*_TEMPERATURE, count)}
    torques = rng.uniform(-_TORQUE, _TORQUE, q.shape)
    columns |= {f"{TORQUE}{j + 1}": column for j, column in enumerate(torques.T)}
    columns[PAYLOAD[0]] = rng.uniform(0.0, _PAYLOAD, count)
    return Poses.from_arrays(q, columns, model.robot.slides)


def random_joints(model: Model, count: int) -> Poses:
    """Return the poses of ``random_poses`` with their joint angles ``(count, n)`` [rad; m of a prismatic joint] alone."""
    return joints_within(model.nominal.limits, count, _SEED)


def joints_within(limits: Array, count: int, seed: int) -> Poses:
    """Return poses with uniform joint angles within limits ``(n, 2)`` [rad; m]; the same poses are kept for the next call, with what they know."""
    return _kept_joints(np.ascontiguousarray(limits, dtype=float).tobytes(), count, seed)


@lru_cache(maxsize=_MOST_KEPT)
def _kept_joints(limits: bytes, count: int, seed: int) -> Poses:
    """Return random poses of joints within limits, which are kept for the next call; the arguments are hashable for that reason.

    Args:
        limits: The bytes of ``(n, 2)`` [rad; m where a joint slides].
        count: Number of poses.
        seed: Of the random numbers.
    """
    low, high = np.frombuffer(limits).reshape(-1, 2).T
    q = low + (high - low) * np.random.default_rng(seed).random((count, len(low)))
    q.setflags(write=False)
    return Poses.of_joints(q)


def _joints(model: Model, count: int, rng: np.random.Generator) -> Array:
    limits = model.nominal.limits
    return rng.uniform(limits[:, 0], limits[:, 1], (count, len(limits)))


def poses_within_limits(limits: Array, measured_poses: Poses, count: int, seed: int) -> Poses:
    """Return random poses within joint limits; other columns take random measured values, and the order of all is the measured median.

    Args:
        limits: ``(n, 2)`` [rad; m of a prismatic joint].
        measured_poses: The poses with what was recorded of them.
        count: How many.
        seed: Of the draws.
    """
    rng = np.random.default_rng(seed)
    q = rng.uniform(limits[:, 0], limits[:, 1], size=(count, len(limits)))
    columns = {name: rng.choice(values, count) for name, values in measured_poses.columns.items()}
    return Poses(q, np.full(count, float(np.median(measured_poses.order))), columns)


def limits_or_measured_ranges(limits: Array, q: Array) -> Array:
    """Return joint limits ``(n, 2)`` [rad], or the range of ``q`` ``(N, n)`` where a joint has none."""
    limits = np.array(limits, dtype=float)
    bounded = np.isfinite(limits) & (np.abs(limits) < _UNBOUNDED)
    return np.where(bounded, limits, ranges_of_joints(q))


def ranges_of_joints(q: Array) -> Array:
    """Return the range of each joint ``(n, 2)`` in angles ``(N, n)``."""
    return np.column_stack([q.min(axis=0), q.max(axis=0)])
