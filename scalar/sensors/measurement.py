"""What every kind of sensor offers to the fit: whitened residual rows, and how they move with the sensor and with its target.

A *target* is what is measured against and is itself unknown: planes for a scanner or a probe, the frame of a tracker. The rows of a
pose depend on the robot only through the pose of the sensor, so a row's derivative is a wrench ``(1, 6)``: a small screw (w, v) of
the sensor, in the base frame, changes the residual by ``wrench . (w, v)``. A new kind of sensor is one file with one subclass.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

from scalar.geometry.se3 import Array

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset

UNSTATED_SIGMA = 1e-4  # m; scales the rows where nothing is stated, until the scatter is measured or for good
LEAST_SIGMA = 1e-9  # m; no sensor is as good, and the rounding of coordinates in metres stays well below it


def stated_sigma(noise: float | None) -> float:
    """Return the standard deviation [m] to whiten with, where a dataset states ``noise`` [m] or None."""
    return UNSTATED_SIGMA if noise is None else max(float(noise), LEAST_SIGMA)


class Target(Protocol):
    """What a sensor measures against: some items (planes, frames), each with the same number of free coordinates."""

    @property
    def parameter_names(self) -> list[str]:
        """Names of all coordinates, item by item."""
        ...

    @property
    def parameter_units(self) -> list[str]:
        """Units of all coordinates."""
        ...

    @property
    def vector(self) -> Array:
        """All coordinates."""
        ...

    def with_vector(self, vector: Array) -> Any:
        """Return the target at other coordinates."""
        ...

    def rebased(self) -> Any:
        """Return the same target with its coordinates counted from where it is."""
        ...

    def expressed_about(self, guess: Any) -> Any:
        """Return the same target in the coordinates that are reported."""
        ...


@dataclass(frozen=True, eq=False)
class Rows:
    """Whitened residual rows of N poses, m each, and their derivatives.

    Attributes:
        residual: ``(N, m)``, in standard deviations.
        wrench: ``(N, m, 6)``, derivative by a screw of the sensor in the base frame [1/rad, 1/m].
        target: ``(N, m, t)``, derivative by the coordinates of the pose's own target item.
        extra: ``(N, m, k)``, derivative by the coefficients of effects on points and surfaces.
    """

    residual: Array
    wrench: Array
    target: Array
    extra: Array


class Measurement(ABC):
    """A dataset as one kind of sensor sees it, reduced to whitened rows.

    Attributes:
        target_index: ``(N,)``, which item of the target a pose measures.
        sigma: Standard deviation of the sensor [m], stated or estimated.
        sigma_stated: Whether the dataset stated it.
    """

    rows_per_pose: int
    equations_per_pose: int  # independent constraints that a pose gives, however many points
    sees_sensor_rotation: bool
    has_metric: bool  # False where the scale of the whole cell leaves no residual
    contact_iterations: int = (
        0  # how often `contact_step` is applied to bring any pose to a perfect measurement
    )
    target_index: Array
    sigma: float
    sigma_stated: bool

    @classmethod
    @abstractmethod
    def of(cls, dataset: Dataset) -> Measurement:
        """Return the measurement of a dataset."""

    @abstractmethod
    def initial_target(self, dataset: Dataset) -> Target:
        """Return the target at the rough guesses that the dataset states."""

    @abstractmethod
    def fitted_target(self, T_base_sensor: Array, target: Target) -> Target:
        """Return the target that fits the points best where the sensor's poses ``(N, 4, 4)`` are given: a closed form."""

    @abstractmethod
    def rows(self, T_base_sensor: Array, target: Target, point_effects: Sequence[Any] = ()) -> Rows:
        """Return the rows at sensor poses ``(N, 4, 4)`` and a target."""

    @abstractmethod
    def reweighted(self, T_base_sensor: Array, target: Target) -> Measurement:
        """Return the same measurement, whitened for the geometry of the estimate."""

    @abstractmethod
    def distances(
        self, T_base_sensor: Array, target: Target, point_effects: Sequence[Any] = ()
    ) -> tuple[Array, Array]:
        """Return per pose the sum of squared residuals [m^2] ``(N,)`` and their number ``(N,)``: unweighted."""

    @abstractmethod
    def perfect_rows(self, T_base_sensor: Array, target: Target, index: Array) -> tuple[Array, Array, Array]:
        """Return the derivatives of a measurement without error at any poses.

        Args:
            T_base_sensor: ``(N, 4, 4)``.
            target: What is measured.
            index: ``(N,)``, which item of the target each pose measures.

        Returns:
            Wrenches ``(N, m, 6)``, derivatives by the target's item ``(N, m, t)``, and which poses allow such a measurement ``(N,)`` bool.
        """

    def contact_step(self, T_base_sensor: Array, target: Target, index: Array, by_angle: Array) -> Array:
        """Return a step of the joint angles ``(N, n)`` [rad] towards a pose that can be measured; zero where every pose can.

        Args:
            T_base_sensor: ``(N, 4, 4)``.
            target: What is measured.
            index: ``(N,)``, which item of the target each pose measures.
            by_angle: ``(N, 6, n)``, the screw of every joint.
        """
        raise NotImplementedError
