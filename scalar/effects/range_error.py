"""The base class of errors of the laser's range."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from scalar.data.poses import Poses
from scalar.effects.effect import Effect
from scalar.effects.picture import Axis, Map, Profile, View
from scalar.effects.places import PointEffect
from scalar.effects.remedies import MEASURE_ON_A_STAGE, NOTHING_FOR_THE_SCANNER
from scalar.geometry.se3 import Array
from scalar.sensors import kind_of
from scalar.sensors.scan_pieces import PIECES

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset

LEAST_INCIDENCE = 0.05  # |n . e|, 87 degrees: a ray that grazes the plane hardly shows an error of its range


def check_measures_range(dataset: Dataset) -> None:
    """Refuse a dataset whose sensor measures no range.

    Raises:
        ValueError: Naming the sensor's kind.
    """
    if not kind_of(dataset).measures_range:
        raise ValueError(
            f"this effect needs a sensor that measures ranges, and a {dataset.sensor.kind} does not"
        )


class ScannerError(PointEffect):
    """An error of the points that a scanner measures, for which the arm is not at fault."""

    of_instrument: ClassVar[bool] = True

    @property
    def how_to_measure(self) -> str:
        """Return how to see it directly."""
        return MEASURE_ON_A_STAGE

    @property
    def in_controller(self) -> str:
        """Return what changes in the controller."""
        return NOTHING_FOR_THE_SCANNER


@dataclass(frozen=True, eq=False)
class RangeError(ScannerError):
    """An error of the measured range along the direction in which the scanner errs."""

    @property
    def target(self) -> dict[str, Any]:
        """Empty: there is one sensor."""
        return {}

    def contact_columns(
        self, poses: Poses, T_base_sensor: Array, planes: Any, plane_index: Array, contact: Array
    ) -> Array:
        """Return the plane's normal along the sensor's x and z axes, the derivatives of a point's height over the plane by its x and z."""
        return contact[:, 1:, None]

    def to_mapping(self) -> dict[str, Any]:
        """Return an empty mapping: the name says all."""
        return {}

    @classmethod
    def from_mapping(cls, mapping: Mapping[str, Any]) -> Self:
        """Return the effect."""
        return cls()

    @classmethod
    def candidates(cls, dataset: Dataset) -> list[Effect]:
        """Return the error, where the sensor measures ranges."""
        return list(cls.parsed(dataset, ())) if kind_of(dataset).measures_range else []

    @classmethod
    def parsed(cls, dataset: Dataset, words: Sequence[str]) -> list[Effect]:
        """Return the error.

        Raises:
            ValueError: The sensor measures no range.
        """
        check_measures_range(dataset)
        return [cls()]

    def not_transferable(self, dataset: Dataset) -> str | None:
        """Return that the other campaign's sensor measures no range."""
        return None if kind_of(dataset).measures_range else "it is an error of a laser's range"

    def range_basis(self, reach: Array) -> Array:
        """Return the correction of the range ``(G, k)`` by every coefficient at ranges ``(G,)`` [m]."""
        raise NotImplementedError

    def pictures(self, view: View) -> list[Profile | Map]:
        """Return what has to be added to the measured range, over the range."""
        return [self._over_range(view)]

    def _over_range(self, view: View, *, without_line: bool = False) -> Profile:
        """Return the correction over the range; ``without_line`` takes off the straight line that fits it best."""
        found = view.pieces(self)
        steep = np.abs(found.incidence) > LEAST_INCIDENCE
        reach, incidence = found.reach[steep], found.incidence[steep]
        rest, fitted = -found.height[steep] / incidence, found.of_effect[steep] / incidence
        x = np.linspace(reach.min(), reach.max(), 61)
        basis = self.range_basis(x)
        curve = np.stack([x, basis @ self.coefficients, view.error_of(self, basis)])
        note = f"Each scan is cut in {PIECES} pieces."
        if without_line:
            line = np.polynomial.Polynomial.fit(reach, fitted, 1)
            straight = np.column_stack([np.ones_like(x), x])
            hat = straight @ np.linalg.lstsq(straight, basis, rcond=None)[0]
            curve = np.stack([x, curve[1] - line(x), view.error_of(self, basis - hat)])
            fitted = fitted - line(reach)
            note += " A straight line is taken off: gain and zero cannot be distinguished from the geometry."
        x_axis, y_axis = Axis("measured range", "m"), Axis("correction of the range", "m")
        std = found.std[steep] / np.abs(incidence)
        return Profile(
            x_axis, y_axis, reach, fitted + rest, rest, std, fitted, curve, pose=found.pose[steep], note=note
        )
