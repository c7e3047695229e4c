"""Simulate campaigns of a tracker: the simulator's engine moves the arm and injects the effects, and a tracker measures one target.

The arm walks through its joint space by short and long moves, so that friction with a memory differs from play. With a linear axis (``rail``), the
engine moves the arm, and its carriage is moved along a line in space. Torques are those that hold arm and payload at the angles that the encoders
read, without noise. Between two sessions the arm stands, and comes to rest: an error that depends on the moves begins anew.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from scalar.data.dataset import Dataset
from scalar.data.declared import Sensor
from scalar.geometry.robot import Robot
from study.common import kinematics
from study.common.kinematics import joint_names
from study.real_arm_trials.campaign import Campaign, config_of, on_rail
from study.real_arm_trials.design import Trial
from study.real_arm_trials.rail import TRAVEL, Rail, RailStage, on_a_rail

if TYPE_CHECKING:
    from scalar.simulation.injected.base import InjectedEffect
    from scalar.simulation.injected.catalogue import Injected
    from scalar.simulation.plan import Workcell

RANGE = 2.2  # rad, to either side of the middle of a joint's range at most
SHARE = 0.9  # of the joints' ranges that is used at most
SHORTEST, LONGEST = (0.03, 0.02), (1.5, 0.8)  # moves: of joints that turn [rad], and of the axis [m]
MEMORY = ("pose_lag", "joint_backlash", "joint_hysteresis")  # depend on the moves before
TRACKER_AWAY, TRACKER_TURNED = 2.0, 1.0  # m, rad


def tracked_campaign(trial: Trial, root: Path) -> Campaign:
    """Return the campaign of a set with a tracker; ``root`` is the folder from which the paths of scenes start."""
    from scalar.simulation.arm import arm_mapping
    from scalar.simulation.injected.catalogue import Injected
    from scalar.simulation.plan import workcell_of

    rng = np.random.default_rng(trial.seed)
    config = config_of(trial, root)
    workcell = workcell_of(config)
    rail = Rail.drawn(rng) if trial.instrument == "rail" else None
    low, high = spans(workcell, rail is not None)
    q = walk(low, high, rail is not None, trial.poses, rng)
    unseen = rng.uniform(low, high, (trial.unseen, len(low)))
    session = np.arange(trial.poses) * trial.sessions // trial.poses
    arm = slice(0 if rail is None else 1, None)
    poses = recorded_poses(trial, config, workcell, q[:, arm])
    effects = Injected(tuple(injected_parts(config["injected"], workcell, poses, session, trial.seed)))
    slides = Injected(tuple(rail_parts(trial, poses, q[:, :1], session))) if rail is not None else None
    frames = partial(placed, workcell, rail)
    jitter = trial.repeatability_rad * rng.standard_normal((trial.poses, workcell.arm.n))
    T = frames(effects, slides, q, poses, jitter)
    trackers = np.stack(
        [kinematics.random_transform(rng, TRACKER_AWAY, TRACKER_TURNED) for _ in range(trial.sessions)]
    )
    points = (trackers[session] @ T)[:, :3, 3] + trial.noise_m * rng.standard_normal((trial.poses, 3))
    columns = {name: poses[name] for name in poses if name != "pose" and name not in joint_names(99)}
    columns["order"] = np.arange(trial.poses)
    if trial.sessions > 1:
        columns["session"] = [f"day {k + 1}" for k in session]
    declared = arm_mapping(workcell.nominal)
    dataset = Dataset.from_arrays(
        robot=Robot.from_mapping(on_a_rail(declared) if rail is not None else declared),
        sensor=Sensor(
            "tracker", workcell.nominal.T_flange_sensor, noise=trial.noise_m if trial.states_noise else None
        ),
        q=q,
        points=points,
        columns=columns,
    )
    table = unseen_poses(poses, workcell, unseen[:, arm], rng)
    truth = frames(effects.at_rest(), None if slides is None else slides.at_rest(), unseen, table, 0.0)
    asked = pd.DataFrame(unseen, columns=joint_names(unseen.shape[1])).assign(
        time=0.0, **{name: table[name] for name in table if name.startswith(("payload", "tau"))}
    )
    entries = [shifted(entry, rail is not None) for entry in effects.record()]
    return Campaign(dataset, (slides.record() if slides else []) + entries, asked, truth)


def shifted(entry: dict[str, Any], rail: bool) -> dict[str, Any]:
    """Return an entry of truth.json with joints as the dataset counts them: after the linear axis, if there is one."""
    by = int(rail)
    target = {
        key: [j + by for j in value]
        if key == "joints"
        else value + by
        if key in ("joint", "source")
        else value
        for key, value in entry["target"].items()
    }
    return entry | {"target": target}


def spans(workcell: Workcell, rail: bool) -> tuple[np.ndarray, np.ndarray]:
    """Return the lowest and highest joint angles that are used ``(n,)`` [rad], before them the travels of the axis [m] if there is one."""
    limits = workcell.nominal.limits
    half = np.minimum(SHARE * (limits[:, 1] - limits[:, 0]) / 2, RANGE)
    middle = limits.mean(axis=1)
    low, high = middle - half, middle + half
    return (np.r_[TRAVEL[0], low], np.r_[TRAVEL[1], high]) if rail else (low, high)


def walk(low: np.ndarray, high: np.ndarray, rail: bool, poses: int, rng: np.random.Generator) -> np.ndarray:
    """Return joint angles ``(N, n)`` [rad; m of an axis] of a walk between bounds ``(n,)``, whose moves are spread evenly in their logarithm."""
    slides = rail & (np.arange(len(low)) == 0)
    shortest, longest = (np.where(slides, pair[1], pair[0]) for pair in (SHORTEST, LONGEST))
    q = np.empty((poses, len(low)))
    q[0] = rng.uniform(low, high)
    for k in range(1, poses):
        step = np.exp(rng.uniform(np.log(shortest), np.log(longest))) * rng.choice([-1, 1], len(low))
        outside = (q[k - 1] + step < low) | (q[k - 1] + step > high)
        q[k] = np.clip(q[k - 1] + np.where(outside, -step, step), low, high)
    return q


def recorded_poses(trial: Trial, config: dict[str, Any], workcell: Workcell, q: np.ndarray) -> pd.DataFrame:
    """Return the simulator's table of poses at angles of the arm ``(N, n)`` [rad], with the columns that the trial records."""
    from scalar.simulation.injected.catalogue import injected_records
    from scalar.simulation.records import recorded_columns

    names = {*trial.record, *injected_records(config["injected"])}
    table = pd.DataFrame(q, columns=joint_names(q.shape[1])).assign(pose=np.arange(len(q)))
    columns = recorded_columns(names, trial.seed, *q.shape, _no_draws, config["stops"])
    table = table.assign(**columns)
    return with_torques(table, workcell, q) if "torque" in names else table


def _no_draws(*_: Any, **__: Any) -> np.ndarray:
    raise AssertionError("these trials record no directions of approach, the only column that draws")


def with_torques(table: pd.DataFrame, workcell: Workcell, q: np.ndarray) -> pd.DataFrame:
    """Return a table with the torques [N m] that hold arm and payload at angles ``(N, n)`` [rad]."""
    from scalar.simulation.load import held_torques
    from scalar.simulation.world import World

    with World() as world:
        world.place_arm(workcell.arm)
        return table.assign(**held_torques(world, workcell.arm.T_flange_sensor, q, table))


def injected_parts(
    entries: list[dict[str, Any]], workcell: Workcell, poses: pd.DataFrame, session: np.ndarray, seed: int
) -> list[InjectedEffect]:
    """Return what the simulator injects for complete entries of ``injected``; ``session`` ``(N,)`` is that of each pose."""
    from scalar.simulation.injected.catalogue import class_of
    from scalar.simulation.injected.stage import Stage
    from scalar.simulation.streams import EFFECTS, stream

    class MeasuredStage(Stage):
        """A stage without target planes: what a tracker measures shows every joint."""

        @property
        def influential(self) -> list[int]:  # pyright: ignore[reportIncompatibleVariableOverride]
            """Return all joints."""
            return list(range(1, self.arm.n + 1))

    parts = []
    for k, entry in enumerate(entries):
        kind = class_of(entry)

        def inject(rows: Any, entry: Any = entry, kind: Any = kind, k: int = k) -> Any:
            stage = MeasuredStage(workcell, poses[rows], np.zeros(rows.sum(), int), k)
            return kind.inject(entry, stage, stream(seed, EFFECTS, k))

        parts.append(by_session(inject, kind.name, session))
    return parts


def rail_parts(trial: Trial, poses: pd.DataFrame, travel: np.ndarray, session: np.ndarray) -> list[Any]:
    """Return what the simulator injects into the linear axis, at travels ``(N, 1)`` [m]."""
    from scalar.simulation.injected.catalogue import class_of

    parts = []
    for entry in filter(on_rail, trial.causes):
        kind, rng = class_of(entry), np.random.default_rng(trial.seed)

        def inject(rows: Any, entry: Any = entry, kind: Any = kind, rng: Any = rng) -> Any:
            return kind.inject(entry, RailStage(travel[rows], poses[rows]), rng)

        parts.append(by_session(inject, kind.name, session))
    return parts


def by_session(inject: Any, name: str, session: np.ndarray) -> Any:
    """Return what ``inject`` makes of rows ``(N,)`` bool of poses; it begins anew in each session if it depends on the moves."""
    if name not in MEMORY:
        return inject(np.ones(len(session), bool))
    each = [inject(session == k) for k in np.unique(session)]
    return replace(each[0], errors=np.concatenate([part.errors for part in each]))


def placed(
    workcell: Workcell,
    rail: Rail | None,
    effects: Injected,
    slides: Injected | None,
    q: np.ndarray,
    poses: pd.DataFrame,
    jitter: Any,
) -> np.ndarray:
    """Return the true frames of the target in the base frame ``(N, 4, 4)``, at readings ``(N, n)`` [rad, m].

    Args:
        workcell: The true workcell.
        rail: The linear axis, which is joint 1 of the readings; None without one.
        effects: What acts in the arm.
        slides: What acts in the linear axis; None without one.
        q: Angles and travels that the encoders read.
        poses: The simulator's table of these poses.
        jitter: Random errors of the arm's joints ``(N, n)`` [rad], or zero.
    """
    from scalar.simulation.truth import arm_frames
    from scalar.simulation.world import World

    if rail is None or slides is None:
        return arm_frames(workcell.arm, effects, q + jitter, poses, evaluating=False)
    T = arm_frames(workcell.arm, effects, q[:, 1:] + jitter, poses, evaluating=False)
    with World() as world:
        travel = q[:, :1] + slides.joint_errors(world, q[:, :1], poses)
    return rail.carrying(travel[:, 0], T)


def unseen_poses(
    poses: pd.DataFrame, workcell: Workcell, q: np.ndarray, rng: np.random.Generator
) -> pd.DataFrame:
    """Return the simulator's table of unseen poses ``(M, n)`` [rad] of a cold arm at rest, with payloads of the campaign if it records them."""
    table = pd.DataFrame(q, columns=joint_names(q.shape[1])).assign(pose=np.arange(len(q)), time=0.0)
    loads = [name for name in poses if name.startswith("payload")]
    if loads:
        drawn = poses[loads].iloc[rng.integers(len(poses), size=len(q))].reset_index(drop=True)
        table[loads] = drawn
    return with_torques(table, workcell, q) if "tau1" in poses else table
