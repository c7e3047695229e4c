"""Rays a second of the simulation against pybullet's own call on the same rays, and the share of the time that finding poses takes."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pybullet

from benchmarks.scenes import CONFIG
from benchmarks.timing import interleaved, line, ratio
from scalar.simulation import load_config, simulate
from scalar.simulation.plan import plan_poses
from scalar.simulation.scanner import BEYOND, cast_fan
from scalar.simulation.scene import SimulatedScene
from scalar.simulation.world import RAYS_PER_BATCH, World

LEAST_RATE = 0.8  # of the bare call's rays a second: the goal
MOST_SHARE = 0.5  # of a simulation from nothing: above it, finding poses would be the bottleneck
MOST_RAYS = 16_000  # of one call; of 16,384 pybullet loses one
POINTS = (100, 640)  # of a scan: the paper's number, and every ray of the fan


def simulation(rounds: int, config_file: Path = CONFIG) -> None:
    """Print rays a second and the share of finding poses for the paper's scene, or that of another config file.

    Args:
        rounds: How often each way is timed.
        config_file: Of the scene that is simulated.
    """
    print(f"simulation, processor time [ms], {rounds} rounds; asked for in brackets")
    print(f"{'':48s}{'median':>9s}{'least':>9s}{'rays/s':>10s}{'of bare':>9s}")
    for points in POINTS:
        _points_a_scan(points, rounds, config_file)
    print()


def _points_a_scan(points: int, rounds: int, config_file: Path) -> None:
    """Print the lines of one number of points in a scan."""
    config = load_config(config_file)
    config["sensor"] = {**config["sensor"], "points_per_scan": points, "rays": max(points, POINTS[-1])}
    config["truth_poses"] = 1
    folder = config_file.parent
    plan = plan_poses(config, base_dir=folder)
    scene = simulate(config, base_dir=folder, plan=plan)
    length = scene.workcell.scanner.range_far * BEYOND
    with World(scene.workcell.target_planes) as world:
        starts, ends = rays_of(scene, length)
        ways = {
            f"bare rayTestBatch, M = {points}, {size} rays a call": _bare(world, starts, ends, size)
            for size in (RAYS_PER_BATCH, MOST_RAYS)
        }
        ways |= {
            "  casting a fan: rays from frames, to ranges": lambda: cast_fan(
                world, scene.T_base_sensor, scene.angles, length
            ),
            "  simulate, poses known": lambda: simulate(config, base_dir=folder, plan=plan),
            "  finding poses": lambda: plan_poses(config, base_dir=folder),
        }
        times = interleaved(ways, rounds)
    bare, _, fan, known, finding = times.values()  # the smaller calls are the faster ones
    for name, each in list(times.items())[:4]:
        print(f"{line(name, each)}{len(starts) / each.median:10.0f}{ratio(bare, each):9.2f}")
    print(line(list(times)[4], finding))
    print(f"  casting a fan: {ratio(bare, fan):.2f} of the bare rate (at least {LEAST_RATE})")
    share = float(np.median(finding.seconds / (finding.seconds + known.seconds)))
    print(f"  finding poses: {share:.2f} of a simulation from nothing (below {MOST_SHARE})", flush=True)


def _bare(world: World, starts: np.ndarray, ends: np.ndarray, size: int) -> Callable[[], None]:
    """Return a call that has pybullet cast rays ``(R, 3)`` [m], already lists of numbers, so many at a time, and drops the answers."""
    batches = [slice(k, k + size) for k in range(0, len(starts), size)]
    lists = [(starts[batch].tolist(), ends[batch].tolist()) for batch in batches]

    def cast() -> None:
        for batch in lists:
            pybullet.rayTestBatch(*batch, physicsClientId=world.client)

    return cast


def rays_of(scene: SimulatedScene, length: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the starts and ends ``(R, 3)`` [m] of all rays of a scene in the base frame."""
    u = np.stack([np.sin(scene.angles), np.zeros_like(scene.angles), np.cos(scene.angles)], axis=-1)
    rays = np.einsum("nij,nmj->nmi", scene.T_base_sensor[:, :3, :3], u) * length
    starts = np.broadcast_to(scene.T_base_sensor[:, None, :3, 3], rays.shape)
    return starts.reshape(-1, 3), (starts + rays).reshape(-1, 3)
