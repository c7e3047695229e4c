"""Simulate the scene of a config: its dataset and its truth.

There are two stages. `plan_poses` finds postures from which each target plane is seen well; this is most of the work, and
does not depend on the noise, the number of points in a scan or the declared model. `simulate` puts the arm into these
postures, casts the laser's rays, adds noise, and records what a user would have. A sweep plans once and simulates often.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from scalar.simulation.acquisition import Acquisition
from scalar.simulation.config import complete_config, poses_wanted
from scalar.simulation.dataset_mapping import dataset_mapping
from scalar.simulation.effects import Effects
from scalar.simulation.errors import SimulationError
from scalar.simulation.injected.catalogue import inject, injected_records
from scalar.simulation.load import held_torques
from scalar.simulation.noise import Noise, noise_from_mapping, noisy_points
from scalar.simulation.optics.imperfect import imperfections
from scalar.simulation.plan import (
    PosePlan,
    Progress,
    Workcell,
    plan_poses,
    scans_text,
    workcell_of,
    workcell_text,
)
from scalar.simulation.ranges import true_ranges
from scalar.simulation.records import recorded_columns
from scalar.simulation.scanner import Scanner, directions
from scalar.simulation.scans import Scans
from scalar.simulation.streams import (
    JOINT_NOISE,
    RANGE_NOISE,
    SCAN_BIAS,
    SCANNER,
    SELECTION,
    stream,
)
from scalar.simulation.transforms import Array
from scalar.simulation.truth import arm_frames, evaluation_poses, truth_mapping
from scalar.simulation.world import World


@dataclass(frozen=True, eq=False)
class SimulatedScene:
    """A dataset and its truth, in memory.

    Attributes:
        config: the complete config.
        dataset: the mapping for dataset.yaml.
        poses, scans: the tables poses.csv and scans.csv.
        truth: the mapping for truth.json.
        workcell: the true arm, target planes and scanner.
        effects: what was injected.
        q: (N, n) [rad], joint angles as the encoders read them, in acquisition order.
        q_true: (N, n) [rad], the same with the joints' noise.
        plane_index: (N,), index of the plane that each pose scans.
        T_base_sensor: (N, 4, 4), the true frames of the sensor.
        ranges: (N, M) [m], true ranges.
        angles: (N, M) [rad], angles of the rays.
        points: (N, M, 2) [m], measured points.
        seen: (N, M) bool, the points that the scanner delivers.
    """

    config: dict[str, Any]
    dataset: dict[str, Any]
    poses: pd.DataFrame
    scans: pd.DataFrame
    truth: dict[str, Any]
    workcell: Workcell
    effects: Effects
    q: Array
    q_true: Array
    plane_index: Array
    T_base_sensor: Array
    ranges: Array
    angles: Array
    points: Array
    seen: Array

    @cached_property
    def truth_poses(self) -> pd.DataFrame:
        """Return the table truth_poses.csv, computed at first use: a sweep may need it only once."""
        return evaluation_poses(self.workcell.arm, self.effects, self.config["truth_poses"], self.poses)

    def true_scans(self) -> Scans:
        """Return the true scans, for scenes of the same workcell and postures."""
        rows = np.argsort(Acquisition.of(self.config, poses_wanted(self.config)).order)
        listed = [rows[self.plane_index[rows] == k] for k in range(len(self.workcell.target_planes))]
        return Scans(
            scans_text(self.config),
            *(tuple(table[at] for at in listed) for table in (self.T_base_sensor, self.angles, self.ranges)),
        )


def simulate(
    config: Mapping[str, Any],
    base_dir: Path | None = None,
    *,
    plan: PosePlan | None = None,
    cast: Scans | None = None,
    effects: Effects | None = None,
    progress: Progress | None = None,
) -> SimulatedScene:
    """Return the dataset that a config describes, and its truth.

    Args:
        config: of a scene.
        base_dir: the folder to which the path of its robot file is relative.
        plan: postures found before for the same workcell, at least as many as are asked for; None to find them.
        cast: true scans of these postures, which are reused if they have every ray and neither effects nor noise of the
            joints act; else rays are cast.
        effects: what to inject instead of the config's `injected`.
        progress: called with (stage, done, of).

    Raises:
        InvalidInput: the config is at fault.
        SimulationError: no postures, a plan for another workcell, or a scan that leaves its target plane.
    """
    config = complete_config(config, base_dir=base_dir)
    workcell = workcell_of(config)
    wanted = poses_wanted(config)
    plan = plan or plan_poses(config, progress=progress)
    _check_plan(plan, config, wanted)
    acquisition = Acquisition.of(config, wanted)
    plane_index, q = acquisition.plane_index, acquisition.sorted(plan.q)
    poses = _poses(config, workcell, acquisition, q)
    effects = effects or inject(config["injected"], workcell, poses, plane_index, config["seed"])
    noise = effects.noise(noise_from_mapping(config["noise"]))
    q_true = q + noise.joint_std * acquisition.draws(JOINT_NOISE, workcell.arm.n)
    chosen = _chosen_rays(workcell.scanner, acquisition)
    angles = workcell.scanner.angles()[chosen]
    known = None
    if cast is not None and cast.workcell == scans_text(config):
        nothing_acts = noise.joint_std == 0 and not effects.record()
        known = cast.at(wanted, acquisition.order, angles) if nothing_acts else None
    if known is None:
        T_base_sensor = arm_frames(workcell.arm, effects, q_true, poses, evaluating=False)
        ranges = true_ranges(config, workcell, effects, T_base_sensor, angles, plane_index, poses)
    else:
        T_base_sensor, ranges = known
    rays = _Rays(chosen, angles, ranges, T_base_sensor)
    points, seen = _measured(config, workcell, effects, noise, acquisition, poses, rays)
    if progress is not None:
        progress("scans", len(q), len(q))
    return SimulatedScene(
        config=config,
        dataset=dataset_mapping(config, workcell, noise),
        poses=poses,
        scans=_scans(points, seen),
        truth=truth_mapping(workcell.arm, workcell.target_planes, noise, effects, poses, config),
        workcell=workcell,
        effects=effects,
        q=q,
        q_true=q_true,
        plane_index=plane_index,
        T_base_sensor=T_base_sensor,
        ranges=ranges,
        angles=angles,
        points=points,
        seen=seen,
    )


@dataclass(frozen=True, eq=False)
class _Rays:
    """The true scans.

    Attributes:
        chosen: (N, M), the pixel of each point.
        angles: (N, M) [rad], angles of the rays.
        ranges: (N, M) [m], true ranges.
        T_base_sensor: (N, 4, 4), the true frames of the sensor.
    """

    chosen: Array
    angles: Array
    ranges: Array
    T_base_sensor: Array


def _check_plan(plan: PosePlan, config: Mapping[str, Any], wanted: Sequence[int]) -> None:
    """Refuse a plan of poses that does not suit a config.

    Raises:
        SimulationError: It is that of another workcell, or has too few poses.
    """
    if plan.workcell != workcell_text(config):
        raise SimulationError(
            "the plan of poses belongs to another workcell; plan again, or simulate its own config"
        )
    if any(len(q) < k for q, k in zip(plan.q, wanted, strict=True)):
        raise SimulationError(
            "the plan holds fewer poses than poses_per_plane asks for; plan again with more"
        )


def _poses(config: Mapping[str, Any], workcell: Workcell, acquisition: Acquisition, q: Array) -> pd.DataFrame:
    """Return the table poses.csv: joint angles ``q`` (N, n) [rad], and what else the config records."""
    names = [workcell.target_planes[k].name for k in acquisition.plane_index]
    poses = pd.DataFrame({"pose": np.arange(len(q)), "plane": names})
    n = workcell.arm.n
    poses[[f"q{i + 1}" for i in range(n)]] = q
    recorded = {*config["record"], *injected_records(config["injected"])}
    columns = recorded_columns(recorded, config["seed"], len(q), n, acquisition.draws, config["stops"])
    for name, column in columns.items():
        poses[name] = column
    if "torque" in recorded:
        with World() as world:
            world.place_arm(workcell.arm)
            for name, column in held_torques(world, workcell.arm.T_flange_sensor, q, poses).items():
                poses[name] = column
    return poses


def _chosen_rays(scanner: Scanner, acquisition: Acquisition) -> Array:
    """Return (N, M), the rays whose points are delivered, rising.

    They are the first M of a random order of the rays: a smaller M takes a subset of the same rays.
    """
    n_poses = len(acquisition.order)
    if scanner.rays <= scanner.points:
        return np.broadcast_to(np.arange(scanner.rays), (n_poses, scanner.rays))
    lottery = acquisition.draws(SELECTION, scanner.rays, uniform=True)
    return np.sort(np.argsort(lottery, axis=1)[:, : scanner.points], axis=1)


def _measured(
    config: Mapping[str, Any],
    workcell: Workcell,
    effects: Effects,
    noise: Noise,
    acquisition: Acquisition,
    poses: pd.DataFrame,
    rays: _Rays,
) -> tuple[Array, Array]:
    """Return the measured points (N, M, 2) [m], and which of them the scanner delivers, (N, M) bool."""
    scanner, ranges, angles = workcell.scanner, rays.ranges, rays.angles
    normals = np.array([plane.axes[:, 2] for plane in workcell.target_planes])[acquisition.plane_index]
    R = rays.T_base_sensor[:, :3, :3]
    white = acquisition.draws(RANGE_NOISE, scanner.rays)
    imperfect = imperfections(
        config["scanner"],
        scanner,
        ranges,
        angles,
        np.einsum("nij,nmj,ni->nm", R, directions(angles), -normals),
        rays.chosen,
        np.take_along_axis(white, rays.chosen, axis=1),
        lambda row: acquisition.rng_of(SCANNER, row),
        stream(config["seed"], SCANNER),
    )
    readings = ranges * np.cos(angles) if scanner.error_axis == "z" else ranges
    points = noisy_points(
        ranges,
        angles,
        noise,
        imperfect.draws,
        acquisition.draws(SCAN_BIAS),
        scanner.error_axis,
        effects.range_errors(readings, angles, poses) + imperfect.errors,
    )
    return points, imperfect.seen


def _scans(points: Array, seen: Array) -> pd.DataFrame:
    """Return the table scans.csv of the points (N, M, 2) [m] that the scanner delivers, (N, M) bool."""
    pose = np.repeat(np.arange(len(points)), seen.sum(1))
    return pd.DataFrame({"pose": pose, "x": points[seen, 0], "z": points[seen, 1]})
