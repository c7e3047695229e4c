"""A simulated campaign: its dataset, and unseen poses with the truth at them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from scalar.data.dataset import Dataset
from study.common.scene_config import scene_config
from study.real_arm_trials.design import Trial

STOP_S = 1800.0  # duration of a stop


@dataclass(frozen=True, eq=False)
class Campaign:
    """What a set needs to be diagnosed and judged.

    Attributes:
        dataset: The dataset that is diagnosed.
        injected: Entries of truth.json of what was injected; joints as the dataset counts them.
        unseen: Joint angles q1..qn [rad, m] of M unseen poses, with the columns that a prediction of them may need.
        truth: True frames of the sensor or the target at them ``(M, 4, 4)``.
    """

    dataset: Dataset
    injected: list[dict[str, Any]]
    unseen: pd.DataFrame
    truth: np.ndarray


def config_of(trial: Trial, root: Path, **entries: Any) -> dict[str, Any]:
    """Return the complete config of a trial's scene; what acts in a rail is left out.

    Args:
        trial: The set.
        root: Folder from which the paths of scenes start.
        entries: Further keys of the config's top level.
    """
    injected = [dict(cause) for cause in trial.causes if not on_rail(cause)]
    stops = {"count": trial.stops, "duration_s": STOP_S}
    keys = {"injected": injected, "record": list(trial.record), "stops": stops, "seed": trial.seed} | entries
    return scene_config(root / f"configs/scenes/{trial.robot}.yaml", [], **keys)


def on_rail(cause: Mapping[str, Any]) -> bool:
    """Return whether an entry acts in the linear axis."""
    return bool(cause.get("on_rail"))
