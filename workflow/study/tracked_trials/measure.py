"""Simulate the datasets of arms with injected causes: a tracker measures one target or three, or a probe touches planes."""

from __future__ import annotations

from typing import Any

import numpy as np

from scalar.data.dataset import Dataset
from scalar.data.declared import PlaneGuess, Sensor
from study.tracked_trials.design import Trial
from study.tracked_trials.flawed_arm import Acquisition, FlawedArm
from study.tracked_trials.tracked_arm import GUESS, TrackedArm

FIRST = "ball"
TARGETS = {"tracker": (FIRST,), "targets": (FIRST, "second", "third"), "probe": (FIRST,)}
"""``{kind of sensor: names of the targets, or of the tip, on the flange}``."""
WIDEST = 2.6  # rad, largest half of a joint's range that is used
# Standard deviation of each component by which the true normals of the planes differ from the axes.
LEANING = 0.05
# Standard deviations of the errors of declared normals (components) and of declared distances [m].
GUESS_TURN, GUESS_DISTANCE = 0.02, 5e-3
# Distance from the plane that counts as contact [m], and largest number of Newton steps towards it.
TOUCHING, ROUNDS = 1e-9, 25
LONGEST = 0.3  # largest step / slope^2 of one Newton step [rad^2/m]


def simulated(trial: Trial) -> tuple[Dataset, np.ndarray, np.ndarray]:
    """Return a trial's dataset, and unseen joint angles ``(M, n)`` [rad] with the true frames of the first target ``(M, 4, 4)``."""
    rng = np.random.default_rng(trial.seed)
    tracked = TrackedArm.drawn(rng, TARGETS[trial.sensor], trial.robot, trial.sessions)
    arm = FlawedArm(tracked, trial.causes, trial.workcell.relative_compliance)
    low, high = tracked.robot.limits.T
    half = trial.share_of_range * np.minimum((high - low) / 2, WIDEST)
    middle = (low + high) / 2
    q = rng.uniform(middle - half, middle + half, (trial.poses, len(low)))
    unseen = rng.uniform(middle - half, middle + half, (trial.unseen, len(low)))
    time = np.cumsum(rng.uniform(20, 40, trial.poses))
    during = Acquisition(
        time,
        float(time[-1] / 3),
        np.where(rng.random(q.shape) < 0.5, -1.0, 1.0),
        trial.repeatability_rad * rng.normal(size=q.shape),
    )
    dataset = (_probe if trial.sensor == "probe" else _tracker)(trial, arm, q, during, rng)
    return dataset, unseen, arm.flange(unseen) @ tracked.targets[FIRST]


def _columns(trial: Trial, during: Acquisition) -> dict[str, Any] | None:
    """Return the columns of poses.csv that the trial records in addition to the joint angles; None without any."""
    columns: dict[str, Any] = {"time": during.time} if trial.records_time else {}
    if trial.records_approach:
        columns |= {f"approach{i + 1}": values for i, values in enumerate(during.approach.T)}
    return columns or None


def _tracker(
    trial: Trial, arm: FlawedArm, q: np.ndarray, during: Acquisition, rng: np.random.Generator
) -> Dataset:
    """Return the dataset of a tracker at joint angles ``(N, n)`` [rad]."""
    stated: dict[str, Any] = {"noise": trial.stated_noise_m}
    if trial.stated_turn_noise_rad is not None:
        stated["rotation_noise"] = trial.stated_turn_noise_rad
    return arm.arm.dataset(
        q,
        rng,
        noise=trial.noise_m,
        turn_noise=trial.turn_noise_rad,
        session=None if trial.sessions == 1 else np.arange(len(q)) * trial.sessions // len(q),
        stated=stated,
        T_base_flange=arm.flange(q, during),
        columns=_columns(trial, during),
    )


def _probe(
    trial: Trial, arm: FlawedArm, q: np.ndarray, during: Acquisition, rng: np.random.Generator
) -> Dataset:
    """Return the dataset of a probe, whose contacts are sought from joint angles ``(N, n)`` [rad]."""
    places = arm.arm.at(q, FIRST)[:, :3, 3]
    normals = np.eye(3)[[plane.axis for plane in trial.workcell.planes]]
    normals += rng.normal(0, LEANING, normals.shape)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    distances = np.array(
        [
            np.quantile(places @ n, plane.behind)
            for n, plane in zip(normals, trial.workcell.planes, strict=True)
        ]
    )
    which = np.arange(len(q)) % len(trial.workcell.planes)
    touched = distances[which] + trial.noise_m * rng.normal(size=len(q))
    q, kept = contacts(arm, q, during, normals[which], touched)
    during, which = during.of(kept), which[kept]
    planes = [
        PlaneGuess(
            plane.name, normal + rng.normal(0, GUESS_TURN, 3), float(distance + rng.normal(0, GUESS_DISTANCE))
        )
        for plane, normal, distance in zip(trial.workcell.planes, normals, distances, strict=True)
    ]
    return Dataset.from_arrays(
        robot=arm.arm.robot,
        sensor=Sensor("probe", GUESS, noise=trial.stated_noise_m, options={}),
        q=q,
        points=None,
        planes=planes,
        plane=[trial.workcell.planes[k].name for k in which],
        columns=_columns(trial, during),
    )


def contacts(
    arm: FlawedArm, q: np.ndarray, during: Acquisition, normals: np.ndarray, distances: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return joint angles ``(M, n)`` [rad] at which the tip of the arm touches its planes, and which of the N poses these are, ``(N,)`` bool.

    Poses that reach no contact within the limits of the joints are left out, and the others are then solved again, since with a lag each pose
    depends on the one that is measured before it.

    Args:
        arm: The arm with its causes.
        q: ``(N, n)`` [rad], joint angles from which the contacts are sought.
        during: The acquisition of the N poses.
        normals: ``(N, 3)``, unit normal of the plane that each pose touches, in the base frame.
        distances: ``(N,)`` [m], distances of these planes from the origin of the base.
    """
    target, limits = arm.arm.targets[FIRST], arm.arm.robot.limits.T
    kept = np.ones(len(q), dtype=bool)
    while True:
        some, normal, distance = during.of(kept), normals[kept], distances[kept]
        moved = q[kept].copy()
        gap = np.full(len(moved), np.inf)
        for _ in range(ROUNDS):
            gap = np.sum((arm.flange(moved, some) @ target)[:, :3, 3] * normal, axis=1) - distance
            if np.all(np.abs(gap) < TOUCHING):
                break
            slope = _slopes(arm, moved, normal)
            step = gap / np.maximum(np.sum(slope**2, axis=1), 1e-9)
            moved -= np.clip(step, -LONGEST, LONGEST)[:, None] * slope
        reached = (np.abs(gap) < TOUCHING) & np.all((moved >= limits[0]) & (moved <= limits[1]), axis=1)
        if reached.all():
            return moved, kept
        kept[np.flatnonzero(kept)[~reached]] = False


def _slopes(arm: FlawedArm, q: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Return how fast each joint moves the tip along the normal ``(N, n)`` [m/rad], without the causes: accurate enough for Newton's method."""
    here, step = arm.arm.at(q, FIRST)[:, :3, 3], 1e-6
    columns = [
        np.sum((arm.arm.at(q + move, FIRST)[:, :3, 3] - here) * normal, axis=1) / step
        for move in step * np.eye(q.shape[1])
    ]
    return np.stack(columns, axis=1)
