"""Simulate the scene of a config: its dataset and its truth.

There are two stages. `plan_poses` finds postures from which each target plane is seen well; this is most of the work, and
does not depend on the noise, the number of points in a scan or the declared model. `simulate` puts the arm into these
postures, casts the laser's rays, adds noise, and records what a user would have. A sweep plans once and simulates often.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from scalar.data.formats import DATASET_FORMAT
from scalar.simulation.arm import arm_mapping, pose_mapping
from scalar.simulation.config import complete_config, poses_wanted
from scalar.simulation.declared import draw_errors, guess_plane
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
from scalar.simulation.scanner import directions
from scalar.simulation.scans import Scans
from scalar.simulation.streams import (
    INITIAL_MODEL,
    JOINT_NOISE,
    ORDER,
    PLANE_GUESS,
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
        rows = np.argsort(_acquisition_order(self.config, poses_wanted(self.config)))
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
    if plan.workcell != workcell_text(config):
        raise SimulationError(
            "the plan of poses belongs to another workcell; plan again, or simulate its own config"
        )
    if any(len(q) < k for q, k in zip(plan.q, wanted, strict=True)):
        raise SimulationError(
            "the plan holds fewer poses than poses_per_plane asks for; plan again with more"
        )

    seed, n, scanner = config["seed"], workcell.arm.n, workcell.scanner
    order = _acquisition_order(config, wanted)
    plane_index = np.repeat(np.arange(len(wanted)), wanted)[order]
    q = np.concatenate([found[:k] for found, k in zip(plan.q, wanted, strict=True)])[order]

    def draws(use: int, *shape: int, uniform: bool = False) -> Array:
        """Return draws (N, *shape) in acquisition order; those of a plane's first poses do not depend on how many poses it has."""
        parts = []
        for k, count in enumerate(wanted):
            rng = stream(seed, use, k)
            parts.append(rng.random((count, *shape)) if uniform else rng.standard_normal((count, *shape)))
        return np.concatenate(parts)[order]

    poses = pd.DataFrame(
        {"pose": np.arange(len(q)), "plane": [workcell.target_planes[k].name for k in plane_index]}
    )
    poses[[f"q{i + 1}" for i in range(n)]] = q
    recorded = {*config["record"], *injected_records(config["injected"])}
    for name, column in recorded_columns(recorded, seed, len(q), n, draws, config["stops"]).items():
        poses[name] = column
    if "torque" in recorded:
        with World() as world:
            world.place_arm(workcell.arm)
            for name, column in held_torques(world, workcell.arm.T_flange_sensor, q, poses).items():
                poses[name] = column
    effects = effects or inject(config["injected"], workcell, poses, plane_index, seed)
    noise = effects.noise(noise_from_mapping(config["noise"]))

    q_true = q + noise.joint_std * draws(JOINT_NOISE, n)
    rays = scanner.angles()
    chosen = np.broadcast_to(np.arange(scanner.rays), (len(q), scanner.rays))
    if scanner.rays > scanner.points:
        # The first M of a random order of the rays: a smaller M takes a subset of the same rays.
        lottery = draws(SELECTION, scanner.rays, uniform=True)
        chosen = np.sort(np.argsort(lottery, axis=1)[:, : scanner.points], axis=1)
    angles = rays[chosen]
    known = None
    if (
        cast is not None
        and cast.workcell == scans_text(config)
        and noise.joint_std == 0
        and not effects.record()
    ):
        known = cast.at(wanted, order, angles)
    if known is None:
        T_base_sensor = arm_frames(workcell.arm, effects, q_true, poses, evaluating=False)
        ranges = true_ranges(config, workcell, effects, T_base_sensor, angles, plane_index, poses)
    else:
        T_base_sensor, ranges = known
    readings = ranges * np.cos(angles) if scanner.error_axis == "z" else ranges
    normals = np.array([target_plane.axes[:, 2] for target_plane in workcell.target_planes])[plane_index]
    cosines = np.einsum("nij,nmj,ni->nm", T_base_sensor[:, :3, :3], directions(angles), -normals)
    plane_and_pose = [(k, i) for k, count in enumerate(wanted) for i in range(count)]
    imperfect = imperfections(
        config["scanner"],
        scanner,
        ranges,
        angles,
        cosines,
        chosen,
        np.take_along_axis(draws(RANGE_NOISE, scanner.rays), chosen, axis=1),
        lambda row: stream(seed, SCANNER, *plane_and_pose[order[row]]),
        stream(seed, SCANNER),
    )
    points = noisy_points(
        ranges,
        angles,
        noise,
        imperfect.draws,
        draws(SCAN_BIAS),
        scanner.error_axis,
        effects.range_errors(readings, angles, poses) + imperfect.errors,
    )
    if progress is not None:
        progress("scans", len(q), len(q))
    scan_table = pd.DataFrame(
        {
            "pose": np.repeat(np.arange(len(q)), imperfect.seen.sum(1)),
            "x": points[imperfect.seen, 0],
            "z": points[imperfect.seen, 1],
        }
    )
    return SimulatedScene(
        config=config,
        dataset=_dataset_mapping(config, workcell, noise),
        poses=poses,
        scans=scan_table,
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
        seen=imperfect.seen,
    )


def _acquisition_order(config: Mapping[str, Any], wanted: list[int]) -> Array:
    """Return the order in which poses, listed plane by plane, are measured.

    The random order sorts by a number drawn for each pose, so that poses keep their relative order if more are planned.
    """
    if config["order"] == "by_plane":
        return np.arange(sum(wanted))
    keys = [stream(config["seed"], ORDER, k).random(count) for k, count in enumerate(wanted)]
    return np.argsort(np.concatenate(keys), kind="stable")


def _dataset_mapping(config: Mapping[str, Any], workcell: Workcell, noise: Noise) -> dict[str, Any]:
    """Return the content of dataset.yaml: what a user would know, and nothing else of the truth."""
    seed = config["seed"]
    declared = workcell.nominal
    if "initial_model" in config:
        errors = draw_errors(config["initial_model"], declared.n, stream(seed, INITIAL_MODEL))
        declared = declared.shifted(errors)
    sensor: dict[str, Any] = {"kind": "line-laser"}
    if config["sensor"]["nominal"] == "given":
        sensor["nominal_pose"] = pose_mapping(declared.T_flange_sensor)
    if config["sensor"]["state_noise"] and noise.range_std > 0:
        sensor["noise"] = noise.range_std
    sensor["error_axis"] = workcell.scanner.error_axis
    return {
        "format": DATASET_FORMAT,
        "name": config["name"],
        "source": "simulated with pybullet by scalar",
        "robot": arm_mapping(declared),
        "sensor": sensor,
        "planes": [
            guess_plane(target_plane, config["plane_guess"], stream(seed, PLANE_GUESS, k))
            for k, target_plane in enumerate(workcell.target_planes)
        ],
    }
