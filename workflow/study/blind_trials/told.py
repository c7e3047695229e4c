"""The error of a calibration that is told the causes: no diagnosis can be expected to do better.

The rigid model with every injected effect at its place, and with an effect for each flaw of scanner and target planes, is fitted to the data that are
diagnosed, without their gross errors. Its error is larger than the noise floor wherever the poses hardly distinguish the coefficients of the effects
from the geometry, or an effect of the catalogue describes a flaw only roughly. So it divides what a diagnosis leaves into what the data cannot give
and what it did not find.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from scalar.effects.command_line import parse_effects
from scalar.errors import ScalarError
from scalar.estimation.calibrate import calibrate
from scalar.estimation.gross_errors import clean
from scalar.estimation.settings import DEFAULTS
from study.blind_trials.run import errors
from study.blind_trials.score import NOISES
from study.common.in_memory import dataset_in_memory

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset
    from scalar.effects.effect import Effect
    from scalar.simulation.scene import SimulatedScene

_PLACES = ("joint", "joints", "plane", "source", "at", "order", "orders")
"""Keys of an injected effect's target, in the order in which a command line names their values."""


def told_error(simulated: SimulatedScene, truth: Mapping[str, Any]) -> dict[str, float | None]:
    """Return ``{"position_told_mm": the mean position error [mm] of the calibration that is told the causes}``.

    The value is None if a cause is no effect of the catalogue, or if the data cannot determine all effects.

    Args:
        simulated: The scene that is diagnosed.
        truth: Its truth, as ``study.blind_trials.stratified_score.trial_score`` takes it.
    """
    dataset = dataset_in_memory(simulated)
    effects = effects_in(truth, dataset)
    if effects is None:
        return {"position_told_mm": None}
    try:
        calibration = calibrate(clean(dataset, DEFAULTS).dataset, effects=effects)
    except ScalarError:
        return {"position_told_mm": None}
    return {"position_told_mm": errors(calibration, simulated.truth_poses, "told")["position_told_mm"]}


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
