"""Define the faults of a dataset whose degree the study varies, such as the share of stray points: each with its values and how it is made."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from scalar.data.dataset import Dataset
from scalar.units import MM
from study.blind_trials.gross_errors import with_gross_errors

Spoil = Callable[[Dataset, float, np.random.Generator], Dataset]
"""A function that returns a dataset with a fault of a given degree, drawn by the generator."""


@dataclass(frozen=True)
class Axis:
    """One kind of fault, in growing degree.

    Attributes:
        label: Label of the figure's axis, with the unit of the values.
        values: The values that are tried, ascending.
        scene_value: The value that the scene itself has; with it nothing is changed, so the dataset is the same for all axes.
        overrides: Returns the keys of the scene (with dots) that a value replaces, and their new values.
        spoil: Returns the simulated dataset with the fault.
    """

    label: str
    values: tuple[float, ...]
    scene_value: float
    overrides: Callable[[float], Mapping[str, Any]] = lambda _: {}
    spoil: Spoil = lambda dataset, value, rng: dataset


def _stray_points(dataset: Dataset, share: float, rng: np.random.Generator) -> Dataset:
    """Return a dataset in which a share of the points is displaced."""
    return with_gross_errors(dataset, {"points": share}, rng)[0]


def _wrong_labels(dataset: Dataset, share: float, rng: np.random.Generator) -> Dataset:
    """Return a dataset in which a share of the poses has the name of a wrong plane."""
    return with_gross_errors(dataset, {"labels": share}, rng)[0]


def _missing_poses(dataset: Dataset, share: float, rng: np.random.Generator) -> Dataset:
    """Return a dataset without a share of the poses of the last plane, chosen at random."""
    of_last = np.flatnonzero(dataset.poses["plane"].to_numpy(dtype=object) == dataset.planes[-1].name)
    out = rng.permutation(of_last)[: round(share * len(of_last))]
    return dataset.subset(np.delete(np.arange(dataset.n_poses), out)) if len(out) else dataset


def _stated_noise(dataset: Dataset, ratio: float, rng: np.random.Generator) -> Dataset:
    """Return a dataset whose stated noise is multiplied by a ratio; one without stated noise is returned as it is."""
    noise = dataset.sensor.noise
    return dataset if noise is None else replace(dataset, sensor=replace(dataset.sensor, noise=ratio * noise))


AXES = {
    "outliers": Axis("stray points [%]", (0.0, 5.0, 10.0, 20.0, 30.0, 40.0), 0.0,
                     spoil=lambda d, v, rng: _stray_points(d, v / 100, rng)),
    "labels": Axis("poses with a wrong plane [%]", (0.0, 2.0, 5.0, 10.0), 0.0,
                   spoil=lambda d, v, rng: _wrong_labels(d, v / 100, rng)),
    "missing": Axis("poses of a plane missing [%]", (0.0, 40.0, 70.0, 85.0, 95.0, 100.0), 0.0,
                    spoil=lambda d, v, rng: _missing_poses(d, v / 100, rng)),
    "noise": Axis("stated over true noise", (0.1, 0.3, 1.0, 3.0, 10.0), 1.0, spoil=_stated_noise),
    "tilt": Axis("tilt of the initial planes [°]", (1.0, 15.0, 30.0, 45.0), 1.0,
                 overrides=lambda v: {"plane_guess.tilt_deg": v}),
    "offset": Axis("offset of the initial planes [mm]", (10.0, 100.0, 200.0, 300.0), 10.0,
                   overrides=lambda v: {"plane_guess.offset_m": v * MM}),
}  # fmt: skip
