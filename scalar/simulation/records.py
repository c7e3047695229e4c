"""The columns of poses.csv apart from joint angles: time, temperature, directions of approach, the payload.

A scene without injected effects may record all of them too, so that a column does not reveal an effect.
"""

from collections.abc import Callable, Collection, Mapping
from typing import Any

import numpy as np

from scalar.simulation.streams import APPROACH, PAYLOAD, TEMPERATURE, TIME, stream
from scalar.simulation.transforms import Array

SIDES = np.array([-1, 1])
SECONDS_A_POSE = (5.0, 15.0)
COLD = 20.0  # degrees C, when the run begins
WARMING = 6.0  # K; the temperature rises in proportion to 1 - exp(-LEVELLING * share of the run), by this much if the run were endless
LEVELLING = 3.0
ROOM = 0.3  # K, amplitude of the swings of the hall's own temperature
SWINGS = (1.5, 4.0)  # number of these swings in a run
LOADS = (0.0, 2.0, 5.0)  # kg; a third of the poses with each
GRIPPED = 0.1  # m; largest coordinate x, y or z of a payload's centre of mass in the flange frame


def recorded_columns(
    names: Collection[str],
    seed: int,
    n_poses: int,
    n_joints: int,
    draws: Callable[..., Array],
    stops: Mapping[str, Any],
) -> dict[str, Array]:
    """Return the columns that poses.csv gets.

    These are `time` [s], `temperature` [degrees C], `approach1`.. (-1, 1), `payload` [kg], and its centre of mass [m] in the flange frame.

    Args:
        names: what to record, of "time", "temperature", "approach", "payload".
        seed: of the scene.
        n_poses, n_joints: their numbers.
        draws: gives (N, n) uniform draws of one of the `streams`, in acquisition order.
        stops: `stops` of the scene: how many pauses, and how long each is [s].
    """
    columns: dict[str, Array] = {}
    time = np.cumsum(stream(seed, TIME).uniform(*SECONDS_A_POSE, n_poses))
    time += stops["duration_s"] * (np.arange(n_poses) * (stops["count"] + 1) // n_poses)
    if "time" in names:
        columns["time"] = np.round(time, 1)
    if "temperature" in names:
        rng = stream(seed, TEMPERATURE)
        share = time / time[-1]
        phase = 2 * np.pi * (rng.uniform(*SWINGS) * share + rng.random())
        rise = WARMING * (1.0 - np.exp(-LEVELLING * share))
        columns["temperature"] = np.round(COLD + rise + ROOM * np.sin(phase), 2)
    if "approach" in names:
        later = draws(APPROACH, n_joints, uniform=True) < 0.5
        columns |= {f"approach{j + 1}": SIDES[later[:, j].astype(int)] for j in range(n_joints)}
    if "payload" in names:
        x, y, z = stream(seed, PAYLOAD).uniform([-GRIPPED, -GRIPPED, 0.0], GRIPPED)
        columns["payload"] = np.array(LOADS)[np.arange(n_poses) * len(LOADS) // n_poses]
        columns |= {
            f"payload_{axis}": np.full(n_poses, round(v, 4)) for axis, v in zip("xyz", (x, y, z), strict=True)
        }
    return columns
