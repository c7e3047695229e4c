"""The tracked arm of the benchmark: the maker's table, a true arm that errs by as much as arms do, and what a tracker measures of it.

Kinematics and noise are those of the studies and call nothing of ``scalar``, so no contestant predicts with the code that made the data.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import yaml
from study.common.kinematics import PARAMETER_KINDS, best_motion, chain, random_transform

from benchmarks.trackers.adapters.exchange import KINDS, Job
from scalar.units import MM

ROBOT = Path(__file__).parents[2] / "configs" / "robots" / "vs060.yaml"
LENGTHS, ANGLES = (0.1 * MM, 0.5 * MM), (1e-3, 2e-3)
"""Between which every true parameter differs from the nominal one [m] and [rad], with either sign."""
NOISE = 0.02 * MM
REFLECTOR = np.array([0.06, -0.04, 0.12])  # m, off the last axis, so that the last joint matters
REFLECTOR_ERROR = 0.5 * MM
TRAINING, TEST = 100, 500
DISTANCE = 3.0  # m, from the tracker to the base


@dataclass(frozen=True, eq=False)
class Scene:
    """A job, and what it hides: the true positions of the reflector at its test poses ``(M, 3)`` [m], in the tracker's frame, without noise."""

    job: Job
    truth: np.ndarray


def tracked_scene(seed: int, *, tilted: bool = False, noise: float = NOISE, errors: float = 1.0) -> Scene:
    """Return the scene of a seed.

    Args:
        seed: Of all that is drawn.
        tilted: Whether the third axis, nominally parallel to the second, is also tilted about y (the Hayati angle beta), as any real one is.
            A table of four parameters a joint then describes the arm only with values far from the nominal ones.
        noise: Standard deviation of a measured coordinate [m].
        errors: Factor of all errors of the arm.
    """
    rng = np.random.default_rng(seed)
    joints = yaml.safe_load(ROBOT.read_text(encoding="utf-8"))["joints"]
    nominal = np.array([[float(joint.get(kind, 0.0)) for joint in joints] for kind in PARAMETER_KINDS])
    limits = np.array([joint["limits"] for joint in joints])
    true = nominal + errors * _errors(rng, nominal.shape[1], tilted)
    reflector = REFLECTOR + errors * REFLECTOR_ERROR * rng.uniform(-1.0, 1.0, 3)
    T_tracker_base = random_transform(rng, DISTANCE, rng.uniform(0.5, 2.5))
    q, q_test = (rng.uniform(limits[:, 0], limits[:, 1], (count, len(joints))) for count in (TRAINING, TEST))
    measured = positions(true, q, reflector, T_tracker_base)
    measured = measured + noise * rng.standard_normal(measured.shape)
    start = best_motion(positions(nominal, q, REFLECTOR, np.eye(4)), measured)
    dh = nominal[[PARAMETER_KINDS.index(kind) for kind in KINDS]].T
    job = Job(dh, limits, REFLECTOR, start, noise, q, measured, q_test, MM)
    return Scene(job, positions(true, q_test, reflector, T_tracker_base))


def _errors(rng: np.random.Generator, n: int, tilted: bool) -> np.ndarray:
    """Return the errors of all parameters ``(5, n)`` in the order of ``PARAMETER_KINDS`` [m, rad]."""
    found = np.zeros((len(PARAMETER_KINDS), n))
    for row, kind in zip(found, PARAMETER_KINDS, strict=True):
        low, high = LENGTHS if kind in ("a", "d") else ANGLES
        row[:] = rng.uniform(low, high, n) * rng.choice([-1.0, 1.0], n)
    beta = found[PARAMETER_KINDS.index("beta")]
    beta[[i for i in range(n) if i != 2 or not tilted]] = 0.0
    return found


def positions(
    geometry: np.ndarray, q: np.ndarray, reflector: np.ndarray, T_tracker_base: np.ndarray
) -> np.ndarray:
    """Return the places of a reflector in the tracker's frame.

    Args:
        geometry: ``(5, n)`` in the order of ``PARAMETER_KINDS`` [m, rad].
        q: Joint angles ``(N, n)`` [rad].
        reflector: ``(3,)``, on the flange [m].
        T_tracker_base: ``(4, 4)``.

    Returns:
        ``(N, 3)`` [m].
    """
    T = T_tracker_base @ chain(geometry, q)
    return T[:, :3, :3] @ reflector + T[:, :3, 3]


def nominal_positions(job: Job, q: np.ndarray) -> np.ndarray:
    """Return where the nominal arm of a job has its reflector at joint angles ``(N, n)`` [rad]: ``(N, 3)`` [m], in the frame of the start."""
    geometry = np.zeros((len(PARAMETER_KINDS), len(job.dh)))
    for kind, column in zip(KINDS, job.dh.T, strict=True):
        geometry[PARAMETER_KINDS.index(kind)] = column
    return positions(geometry, q, job.reflector, job.T_tracker_base)
