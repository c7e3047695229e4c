"""A calibration that is told the causes: its error, and how significant each cause is in it. No diagnosis can be expected to do better.

The rigid model with every injected effect at its place, and with an effect for each flaw of scanner and target planes, is fitted to the data that are
diagnosed, without their gross errors. Its error is larger than the noise floor wherever the poses hardly distinguish the coefficients of the effects
from the geometry, or an effect of the catalogue describes a flaw only roughly. So it divides what a diagnosis leaves into what the data cannot give
and what it did not find. An effect that is not significant even there cannot be found.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from scalar.effects.command_line import parse_effects
from scalar.errors import ScalarError
from scalar.estimation.calibrate import calibrate
from scalar.estimation.gross_errors import clean
from scalar.estimation.settings import DEFAULTS
from study.blind_trials.run import errors
from study.blind_trials.score import NOISES, Entry, same
from study.common.in_memory import dataset_in_memory

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset
    from scalar.effects.effect import Effect
    from scalar.estimation.result import Calibration
    from scalar.simulation.scene import SimulatedScene

_PLACES = ("joint", "joints", "plane", "source", "at", "order", "orders")
"""Keys of an injected effect's target, in the order in which a command line names their values."""


def told(simulated: SimulatedScene, truth: Mapping[str, Any]) -> dict[str, Any]:
    """Return what a calibration that is told the causes achieves: its error, and how significant each cause is in it.

    Args:
        simulated: The scene that is diagnosed.
        truth: Its truth, as ``study.blind_trials.stratified_score.trial_score`` takes it.

    Returns:
        - ``position_told_mm``: its mean position error [mm]; None if a cause is no effect of the catalogue, or if the data cannot determine all
          effects.
        - ``told_significance``: JSON, for each injected effect its number of ``significances``; null for one that is no effect of the catalogue.
    """
    dataset = dataset_in_memory(simulated)
    effects = effects_in(truth, dataset)
    nothing = {"position_told_mm": None, "told_significance": json.dumps([None] * len(truth["injected"]))}
    if effects is None:
        return nothing
    try:
        calibration = calibrate(clean(dataset, DEFAULTS).dataset, effects=effects)
    except ScalarError:
        return nothing
    error = errors(calibration, simulated.truth_poses, "told")["position_told_mm"]
    found = significances(calibration)
    told = [next((z for entry, z in found if same(entry, injected)), None) for injected in truth["injected"]]
    return {"position_told_mm": error, "told_significance": json.dumps(told)}


def significances(calibration: Calibration) -> list[tuple[Entry, float]]:
    """Return for each effect its name and target, and by how many standard errors its coefficients differ from zero beyond chance.

    Wald's statistic ``W = c^T V^-1 c`` of k coefficients c with covariance V is k in the mean where all of them are zero; the number is the root of
    ``W - k``, or zero.
    """
    where = {name: index for index, name in enumerate(calibration.free)}
    found = []
    for effect, names in zip(calibration.model.effects, calibration.model.effect_names, strict=True):
        free = [k for k, name in enumerate(names) if name in where]
        own = [where[names[k]] for k in free]
        c = effect.coefficients[free]
        wald = float(c @ np.linalg.pinv(calibration.covariance[np.ix_(own, own)], hermitian=True) @ c)
        entry = {"name": effect.name, "target": effect.target}
        found.append((entry, float(np.sqrt(max(wald - len(own), 0.0)))))
    return found


def effects_in(truth: Mapping[str, Any], dataset: Dataset) -> tuple[Effect, ...] | None:
    """Return the effects of the catalogue that describe all that is true of a scene, each once; None if a cause has no name there.

    A random error of the poses has no coefficients that could be told, and is left out.

    Args:
        truth: ``injected`` (entries of truth.json), ``scanner`` and ``surface`` (blocks of truth.json, or None).
        dataset: The dataset of the scene.
    """
    if any(entry["name"] == "unknown" for entry in truth["injected"]):
        return None
    words = [words_of(entry) for entry in truth["injected"] if entry["name"] not in NOISES]
    if (truth.get("surface") or {}).get("bow_m"):
        words += [f"plane_bow:{plane.name}" for plane in dataset.planes]
    if (truth.get("scanner") or {}).get("linearity_m"):
        words.append("sensor_map")
    return parse_effects(",".join(dict.fromkeys(words)), dataset)


def words_of(entry: Mapping[str, Any]) -> str:
    """Return what a command line says to free an injected effect at its place, such as ``joint_harmonic:4:2``."""
    target = entry.get("target") or {}
    values: list[Any] = []
    for key in _PLACES:
        if key in target:
            value = target[key]["order"] if key == "at" else target[key]
            values += value if isinstance(value, list) else [value]
    return ":".join(
        [entry["name"], *(f"{value:g}" if isinstance(value, float) else f"{value}" for value in values)]
    )
