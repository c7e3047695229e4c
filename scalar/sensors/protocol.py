"""The protocol that every kind of sensor implements. A new kind is one class in one file.

A kind of sensor is a subclass of ``Measurement``. The class says what the kind is able to do (its capabilities) and what a dataset folder
of this kind holds (``format``); an object of the class is the measurement of one dataset, reduced to whitened residual rows.

The part of the protocol that concerns noise and weights is in ``scalar.sensors.noise_protocol``. The types that a kind returns are in
``scalar.sensors.rows``, the objects that it measures in ``scalar.sensors.target``, and the further methods of a kind that scans planes in
``scalar.sensors.scans``.

Most kinds predict what they measure, ``h(T_base_sensor, target)``, and subtract what was measured: they are subclasses of ``PointByPoint``
(``scalar.sensors.point_by_point``) and supply h. Kinds that reduce many points to a few rows implement ``Measurement`` itself.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from scalar.data.sensor_formats import SensorFormat
from scalar.errors import Undetermined
from scalar.geometry.se3 import Array
from scalar.sensors.noise_protocol import NoiseProtocol
from scalar.sensors.rows import Pieces, Rows, UsualNoise
from scalar.sensors.target import Guess, Target

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset


class Measurement(NoiseProtocol):
    """The protocol: a subclass is a kind of sensor, and an object of it is the measurement of one dataset.

    A kind has to define ``format``, ``words``, ``rows_per_pose``, the capabilities that differ from those below, and the abstract methods.
    Everything else has a default that is right for a kind that gives a few rows for each pose and no further points.

    Attributes:
        format: What a dataset folder of the kind holds.
        words: Name of the kind in reports.
        measured: The word with which reports describe its poses, such as "tracked".
        target_words: Name of the target in messages, such as "planes" or "tracker".
        on_flange: What of the kind sits on the flange, for messages, and what may be wrong if that comes out turned from where the dataset states
            it, as a clause after "whether".
        residual_words: What the residual of a pose is, as the label of an axis.
        usual_noise: What instruments of the kind scatter by; None where the data show the noise even if nobody states it.
        observes_orientation: Whether the rows depend on the orientation of the sensor on the flange.
        carries_scale: Whether the measurement has a length of its own. If it has none, no residual shows the scale of the workcell.
        scans: Whether a pose is a scan of several points along a line on a plane. Its scatter then shows the noise, and its shape a bent plane.
        measures_range: Whether the points are ranges along rays in the sensor's own frame, so that errors of the range act on them.
        measures_positions: Whether the points are positions in the frame of an instrument that stands apart from the arm. Its errors act on them.
        needs_spanning_planes: Whether a dataset is refused if the normals of its planes do not span space.
        contact_iterations: How often ``contact_step`` is applied to bring any pose to a perfect measurement.
        equations_per_pose: Most independent equations that a pose gives, however many points it has.
        target_index: ``(N,)``, which item of the target a pose measures.
    """

    format: ClassVar[SensorFormat]
    words: ClassVar[str]
    measured: ClassVar[str] = "measured"
    target_words: ClassVar[str] = "target"
    on_flange: ClassVar[tuple[str, str]] = "sensor", "the last joint has another zero"
    residual_words: ClassVar[str] = "distance between measurement and model"
    usual_noise: ClassVar[UsualNoise | None] = None
    observes_orientation: bool = False
    carries_scale: bool = True
    scans: bool = False
    measures_range: bool = False
    measures_positions: bool = False
    needs_spanning_planes: bool = False
    contact_iterations: int = 0

    target_index: Array

    # What every kind has to implement

    @classmethod
    @abstractmethod
    def of(cls, dataset: Dataset, extra_basis: Sequence[str] = ()) -> Self:
        """Return the measurement of a dataset.

        Args:
            dataset: What was measured.
            extra_basis: Names of the functions of a point that effects on points need; for kinds that reduce points to rows.
        """

    @abstractmethod
    def initial_target(self, dataset: Dataset) -> Any:
        """Return the target at the initial guesses that the dataset states, a ``Target``."""

    @abstractmethod
    def fitted_target(self, T_base_sensor: Array, target: Target) -> Any:
        """Return the target that fits best to given poses of the sensor ``(N, 4, 4)``, in closed form."""

    @abstractmethod
    def rows(self, T_base_sensor: Array, target: Target, point_effects: Sequence[Any] = ()) -> Rows:
        """Return the rows at sensor poses ``(N, 4, 4)`` and a target, effects on points and surfaces applied."""

    def extra_columns(self, T_base_sensor: Array, target: Target, point_effects: Sequence[Any]) -> Array:
        """Return the derivatives ``(N, m, k)`` of the rows by the coefficients of effects on points and surfaces: ``Rows.extra`` alone."""
        return self.rows(T_base_sensor, target, point_effects).extra

    def by_range_scale(self, T_base_sensor: Array, target: Target) -> Array | None:
        """Return the derivatives ``(N, m)`` of the rows by a factor on all ranges, if they depend on it; the default is None."""
        return None

    @abstractmethod
    def distances(
        self, T_base_sensor: Array, target: Target, point_effects: Sequence[Any] = ()
    ) -> tuple[Array, Array]:
        """Return for each pose the unweighted sum of squared residuals ``(N,)`` [m^2] and their number ``(N,)``."""

    @abstractmethod
    def perfect_rows(self, T_base_sensor: Array, target: Target, index: Array) -> tuple[Array, Array, Array]:
        """Return the derivatives of an error-free measurement at arbitrary poses.

        Args:
            T_base_sensor: ``(N, 4, 4)``.
            target: What is measured.
            index: ``(N,)``, which item of the target each pose measures.

        Returns:
            Wrenches ``(N, m, 6)``, derivatives by the target's item ``(N, m, t)``, and which poses allow such a measurement ``(N,)`` bool.
        """

    @classmethod
    def target_motion(cls, dataset: Dataset) -> Any:
        """Return the motion of the base relative to the measuring instrument, as references on the base show it.

        Returns:
            Screws ``(N, 6)`` [rad, m] in the base frame; None if the kind measures no references, or the dataset has none. The default is None.
        """
        return None

    @classmethod
    def shows_turns(cls, dataset: Dataset) -> bool:
        """Return whether a small turn of the sensor on the flange would change the rows of a dataset; by default as ``observes_orientation`` says."""
        return cls.observes_orientation

    # How the target is saved

    @classmethod
    def declared_target(cls, dataset: Dataset) -> Any:
        """Return the target as the dataset declares it, whatever was measured."""
        return cls.of(dataset).initial_target(dataset)

    @classmethod
    @abstractmethod
    def target_to_mapping(cls, target: Target, std: Mapping[str, float]) -> dict[str, Any]:
        """Return what ``calibration.json`` says of the target: ``{"target": ...}``, or ``planes`` for kinds that measure planes.

        Args:
            target: In the coordinates that are reported.
            std: Standard errors of the free parameters, by name.
        """

    @classmethod
    @abstractmethod
    def target_from_mapping(cls, mapping: Mapping[str, Any]) -> Any:
        """Return the target of ``target_to_mapping`` from a whole ``calibration.json``, in the coordinates that are reported."""

    # How the fit starts, and what it needs

    def first_guesses(
        self, T_base_flange: Array, target: Target, gravity: Array, thorough: bool
    ) -> list[Guess]:
        """Return guesses of the sensor's pose from the measurement alone.

        Args:
            T_base_flange: ``(N, 4, 4)``, of the nominal arm.
            target: At its initial guess.
            gravity: ``(3,)`` [m/s^2], base frame.
            thorough: Whether the dataset states no nominal pose, so that the guesses have to suffice.

        Raises:
            Undetermined: The kind can make no guess.
        """
        raise Undetermined(["state sensor.nominal_pose: this kind of sensor needs it"])

    def contact_step(self, T_base_sensor: Array, target: Target, index: Array, by_angle: Array) -> Array:
        """Return a step of the joint angles ``(N, n)`` [rad] towards a pose that can be measured; for kinds that cannot measure every pose.

        Args:
            T_base_sensor: ``(N, 4, 4)``.
            target: What is measured.
            index: ``(N,)``, which item of the target each pose measures.
            by_angle: ``(N, 6, n)``, the screw of every joint.
        """
        raise NotImplementedError

    @property
    def contact_factors(self) -> Array | None:
        """Return F ``(N, m, 3)`` if the rows are ``F c``, with c the contact vector ``(n.o - d, n.X, n.Z)`` of a plane; else None."""
        return None

    @property
    def equations_per_pose(self) -> int:
        """Return how many independent equations a pose gives at most."""
        return self.rows_per_pose

    @property
    def equations(self) -> Array:
        """Return the number of independent equations of every pose ``(N,)`` int."""
        return np.full(len(self.target_index), self.equations_per_pose, dtype=int)

    def points_in_base(self, T_base_sensor: Array) -> tuple[Array, Array]:
        """Return the measured points in the base frame ``(P, 3)`` [m], and the index at which those of each pose begin ``(N + 1,)``.

        The default is one point for each pose, the sensor's origin.
        """
        return T_base_sensor[:, :3, 3], np.arange(len(T_base_sensor) + 1)

    def scatter_in_base(self, T_base_sensor: Array) -> tuple[Array, Array, Array]:
        """Return the number ``(N,)`` and mean ``(N, 3)`` [m] of each pose's points in the base frame, and factors F of their scatter.

        F is ``(N, k, 3)`` [m], and ``F^T F`` the sum of products of the points about their mean. The default is one point for each pose.
        """
        return np.ones(len(T_base_sensor)), T_base_sensor[:, :3, 3], np.zeros((len(T_base_sensor), 0, 3))

    # How the residual is shown

    @property
    def shift_rows(self) -> slice:
        """Return which rows of a pose measure the shift of the whole pose."""
        return slice(None)

    def shift(self, predicted: Array, residual: Array) -> tuple[Array, Array, Array]:
        """Return for each pose the predicted shift, the shift of the residual along it, and the standard error of the latter, ``(N,)`` [m] each.

        Args:
            predicted: ``(N, m)``, whitened rows.
            residual: ``(N, m)``, whitened rows.
        """
        size = np.linalg.norm(predicted, axis=1)
        along = predicted / np.maximum(size, 1e-300)[:, None]
        sigma = np.full(len(size), self.sigma)
        return size * sigma, np.sum(along * residual, axis=1) * sigma, sigma

    def shown_residual(self, residual: Array) -> Array:
        """Return the residual of each pose ``(N,)`` [m] from whitened rows ``(N, m)``; by default its size, without a sign."""
        return np.linalg.norm(residual, axis=1) * self.sigma

    def pieces(
        self, T_base_sensor: Array, target: Target, point_effects: Sequence[Any], effect: Any
    ) -> Pieces:
        """Return the measurements on planes, each scan in pieces, for maps of a plane's height.

        Args:
            T_base_sensor: ``(N, 4, 4)``.
            target: The planes.
            point_effects: All effects on points and surfaces, bound to the poses.
            effect: The effect whose pieces are asked for, bound to the poses.
        """
        raise NotImplementedError(f"a {self.words} has no points on planes")
