"""Compute the predictions of all candidates, without the published errors, and keep them in a file, since they take most of the study's time."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from scalar.data.io.atomic import atomic_write
from scalar.geometry.se3 import Array
from study.published_curves.candidates import CANDIDATES, STEPS, Prediction, predict
from study.published_curves.curves import Curves, Setting, read_curves
from study.published_curves.ensemble import build_ensemble
from study.published_curves.other_workcells import offset_covariance

_TABLES = ("nodes", "mean", "covariance", "shares")


@dataclass(frozen=True, eq=False)
class Predictions:
    """The predictions of the candidates, and the uncertainty that they have in common.

    Attributes:
        predictions: ``{name: prediction}`` of the candidates that are effects.
        offset: ``(12, 12)``, covariance of the offset of the authors' workcell, as ``offset_covariance`` returns it.
        others: ``{workcell: mean differences of its log errors}``, as ``offset_covariance`` returns them.
    """

    predictions: dict[str, Prediction]
    offset: Array
    others: dict[str, list[float]]

    def save(self, path: str | Path) -> None:
        """Write to an .npz file, whole or not at all."""
        content: dict[str, Any] = {"offset": self.offset, "others": np.array(json.dumps(self.others))}
        for name, prediction in self.predictions.items():
            content |= {f"{name}/{table}": getattr(prediction, table) for table in _TABLES}
        with atomic_write(path) as temporary, open(temporary, "wb") as file:
            np.savez(file, **content)


def load_predictions(path: str | Path) -> Predictions:
    """Return what ``Predictions.save`` wrote."""
    with np.load(path, allow_pickle=False) as content:
        predictions = {
            c.name: Prediction(c, *(content[f"{c.name}/{table}"] for table in _TABLES))
            for c in CANDIDATES
            if f"{c.name}/mean" in content
        }
        return Predictions(predictions, content["offset"], json.loads(str(content["others"])))


def predict_runs(scene: str | Path, published: pd.DataFrame, options: Mapping[str, Any]) -> Predictions:
    """Return what the candidates predict for the settings of the published runs.

    Args:
        scene: Config file of the original paper's workcell.
        published: published_curves.csv, of which only the settings of the runs are used.
        options: The config's block ``published_curves`` (its schema describes the keys), and ``first_seed``.

    Raises:
        InvalidInput: The scene is at fault.
        SimulationError: Too few postures see a target plane.
    """
    from scalar.simulation.config import load_config

    scene = Path(scene)
    config = load_config(scene)
    curves = runs_to_weigh(config, published, options)
    first, draws = options["first_seed"], options["draws"]
    seeds = range(first, first + options["seeds"])
    ensemble = build_ensemble(
        config, scene.parent, seeds, draws, curves.settings, STEPS, options["followed_seeds"]
    )
    predictions = predict(ensemble, CANDIDATES, curves.settings)
    few = range(first, first + options["other_workcell_seeds"])
    offset, others = offset_covariance(
        config, scene.parent, options["other_workcells"], _base(config), few, draws
    )
    return Predictions(predictions, offset, others)


def runs_to_weigh(config: Mapping[str, Any], published: pd.DataFrame, options: Mapping[str, Any]) -> Curves:
    """Return the published runs, without those that the config leaves out or whose poses give fewer equations than unknowns.

    A scan of a plane gives two equations. The unknowns are four parameters of each joint, six of the sensor and three of each plane, less those
    that the scene declares exact.

    Args:
        config: Config of the original paper's workcell.
        published: published_curves.csv.
        options: The config's block ``published_curves``.
    """
    joints, fixed = len(config["robot"]["joints"]), config.get("initial_model", {}).get("exact", ())
    unknowns = 4 * joints + 6 + 3 * len(config["planes"]) - len(fixed)
    return read_curves(published, _base(config), options["leave_out"], -(-unknowns // 2))


def _base(config: Mapping[str, Any]) -> Setting:
    """Return the setting that a scene describes, from which each sweep varies one field."""
    return Setting(
        poses=config["poses_per_plane"] * len(config["planes"]),
        points=config["sensor"]["points_per_scan"],
        sigma=config["noise"]["range_noise_std_m"],
        offset=config["plane_guess"]["offset_m"],
        tilt=config["plane_guess"]["tilt_deg"],
    )
