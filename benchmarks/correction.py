"""Time the correction of joint angles: poses per second on one core, for an arm whose six joints all have compliance and gear harmonics.

Poses are uniform within the joint limits, so one in ten is near a singularity and takes more steps; the second figure leaves these out.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from benchmarks.timing import interleaved
from scalar.data.io.plain_yaml import load_yaml
from scalar.data.poses import Poses
from scalar.effects.joint_compliance import JointCompliance
from scalar.effects.joint_harmonic import JointHarmonic
from scalar.estimation.correction import correct_joints
from scalar.estimation.model import Model
from scalar.geometry.robot import Robot
from tests.calibrated_arms import calibrated

POSES = 20_000
TARGET = 20_000  # poses a second
_ROBOT = Path(__file__).parents[1] / "configs" / "robots" / "vs060.yaml"


def corrected_model() -> Model:
    """Return an arm that is off by some tenths of a millimetre, with the compliance and three harmonics of every joint."""
    robot = Robot.from_mapping(load_yaml(_ROBOT))
    rng = np.random.default_rng(1)
    joints = range(1, robot.n_joints + 1)
    pairs = tuple((j, f) for j in joints for f in range(j, robot.n_joints + 1))
    effects = [
        JointCompliance(pairs, coefficients=1e-4 * rng.normal(size=2 * len(pairs))),
        *(JointHarmonic(j, (1, 2, 4), coefficients=2e-4 * rng.normal(size=6)) for j in joints),
    ]
    return calibrated(robot, rng, tuple(effects), size=0.3).model


def correction(rounds: int) -> None:
    """Print how many poses are corrected per second of processor time."""
    model = corrected_model()
    n, slides = model.robot.n_joints, model.robot.slides
    low, high = model.robot.limits.T
    poses = Poses.from_arrays(np.random.default_rng(2).uniform(low, high, (POSES, n)), {}, slides)
    regular = Poses.from_arrays(poses.q[~correct_joints(model, poses).near_singular], {}, slides)
    ways: dict[str, Callable[[], object]] = {
        "all poses": lambda: correct_joints(model, poses),
        "those that are not near a singularity": lambda: correct_joints(model, regular),
    }
    sizes = {"all poses": len(poses), "those that are not near a singularity": len(regular)}
    times = interleaved(ways, rounds)
    print(
        f"\ncorrected joint angles, compliance and harmonics of {n} joints: poses a second of processor time"
    )
    for name, taken in times.items():
        print(
            f"{name:48s}{sizes[name] / taken.median:9.0f}{sizes[name] / taken.least:9.0f}   (median, best of {rounds})"
        )
    best = sizes["all poses"] / times["all poses"].least
    print(f"the target is {TARGET}: {'met' if best >= TARGET else 'missed'} by the best round over all poses")
