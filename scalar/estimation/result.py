# pyright: reportMissingTypeStubs=false, reportUnknownMemberType=false
"""The result of a calibration: a model with its covariance and the reasons of fixed parameters, which predicts, and is saved and loaded."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from scalar.data.dataset import Dataset
from scalar.data.io.atomic import write_json
from scalar.data.poses import Poses
from scalar.data.unit_suspicions import refuse_degrees
from scalar.effects.saving import effect_to_mapping
from scalar.estimation.calibration_file import check_effects_made
from scalar.estimation.calibration_reader import FORMAT, read_calibration
from scalar.estimation.correction import correct_joints, correct_table
from scalar.estimation.effect_bases import EffectBases
from scalar.estimation.kinematics import Kinematics
from scalar.estimation.model import Model
from scalar.estimation.prediction_covariance import pose_deviations
from scalar.estimation.reporting import reporting, sensor_mapping
from scalar.estimation.saved_calibration import saved_fields, standard_dh_mapping
from scalar.estimation.targets_on_flange import sensor_to_target
from scalar.geometry.robot import fixed_transform_mapping
from scalar.geometry.se3 import Array
from scalar.sensors import kind_named, kind_of
from scalar.units import MM

if TYPE_CHECKING:
    import pandas as pd

PREDICTION_COLUMNS = ("pose", "x", "y", "z", "rx", "ry", "rz")


@dataclass(frozen=True, eq=False, repr=False)
class Calibration:
    """A calibrated model.

    Attributes:
        model: The model in reporting coordinates: the sensor's rotation vector is absolute, normals are stated relative to the initial guesses.
        sensor: Kind, stated noise and error axis, as the dataset has them.
        free: Names of the parameters that were estimated.
        covariance: ``(F, F)``, covariance of the free parameters, in the products of their units.
        fixed: ``{name: reason}`` of every parameter that was not estimated.
        gauge: The directions that the data do not determine: one mapping for each, with the parameter that was fixed because of it
            (``held``), the reason, the parameters that would take up its change (``moves_with``) and the cause.
        residual_rms: Root mean square distance of points and target [m].
        summary: Numbers and texts that describe the calibration: numbers of poses and points, noise, misfit, how the fit started and ended, and
            what is suspected of the set-up.
        noise: The components of the noise by which the measurements were weighted, as the file lists them; none if it is white and of one size.
    """

    model: Model
    sensor: Mapping[str, Any]
    free: tuple[str, ...] = ()
    covariance: Array = field(default_factory=lambda: np.zeros((0, 0)))
    fixed: Mapping[str, str] = field(default_factory=dict[str, str])
    gauge: tuple[Mapping[str, Any], ...] = ()
    residual_rms: float = 0.0
    summary: Mapping[str, Any] = field(default_factory=dict[str, Any])
    noise: tuple[Mapping[str, Any], ...] = ()

    @classmethod
    def nominal(cls, dataset: Dataset, T_flange_sensor: Array | None = None) -> Calibration:
        """Return the model as the dataset declares it, with nothing estimated: the state before calibration.

        Args:
            dataset: Gives robot, sensor and planes.
            T_flange_sensor: ``(4, 4)``, for a dataset that states no pose of the sensor.

        Raises:
            ValueError: Neither the dataset nor the argument states a pose of the sensor.
        """
        T = dataset.sensor.T_flange_sensor if T_flange_sensor is None else T_flange_sensor
        if T is None:
            raise ValueError("the dataset states no pose of the sensor")
        model = Model.at(dataset.robot, T, kind_of(dataset).declared_target(dataset))
        return cls(reporting(model, model.target), sensor_mapping(dataset))

    def __repr__(self) -> str:
        """Return a line with what was calibrated and how well; the numbers are in ``parameters()`` and ``model``."""
        effects = ", ".join(effect.title for effect in self.model.effects) or "no effects"
        sensor, residual = self.sensor["kind"], f"residual {self.residual_rms / MM:.4f} mm RMS"
        return f"<Calibration of {self.model.nominal.name} by a {sensor}: {len(self.free)} parameters, {effects}, {residual}>"

    @property
    def std(self) -> dict[str, float]:
        """Return the standard error of every free parameter, in its unit."""
        return dict(zip(self.free, np.sqrt(np.diag(self.covariance)), strict=True))

    @property
    def effect_std(self) -> list[list[float | None]]:
        """Return for each effect the standard errors of its coefficients, None for those that were not estimated."""
        std = self.std
        return [
            [float(std[name]) if name in std else None for name in names] for names in self.model.effect_names
        ]

    @property
    def observes_orientation(self) -> bool:
        """Return whether the measurements depend on the sensor's orientation on the flange; if not, that orientation is the declared one."""
        return kind_named(self.sensor["kind"]).observes_orientation or "sensor_rx" in self.free

    def parameters(self) -> dict[str, dict[str, Any]]:
        """Return ``{name: {value, std, unit, held, reason, prior}}`` of every parameter; prior is ``{value, std}`` or None."""
        std = self.std
        model = self.model
        priors = {prior.name: {"value": prior.mean, "std": prior.std} for prior in model.priors}
        return {
            name: {
                "value": float(value),
                "std": float(std[name]) if name in std else None,
                "unit": unit,
                "held": name not in std,
                "reason": None if name in std else self.fixed.get(name, "nominal"),
                "prior": priors.get(name),
            }
            for name, value, unit in zip(model.names, model.vector, model.units, strict=True)
        }

    def predict(
        self, q: ArrayLike | pd.DataFrame, *, target: str | None = None, **columns: ArrayLike
    ) -> Array:
        """Return the sensor's frames in the base frame ``(N, 4, 4)``, all effects applied.

        Args:
            q: ``(N, n)`` [rad], joint angles as the encoders read them; or a table with q1..qn and the optional columns
                of poses.csv.
            target: Name of a target, where several were measured on one flange; the sensor is the first of them.
            columns: The optional columns of poses.csv that an effect needs, by name, if ``q`` is an array: ``temperature``
                [deg C], ``time`` [s], ``order`` (without it: the state at the end), ``approach`` as ``(N, n)``; ``(N,)``
                each, or one number for all poses.

        Raises:
            InvalidInput: A column that an effect needs is missing; an array has the wrong shape; no target has that name; or a joint angle is
                more than a turn beyond the limits of its joint, as happens if degrees are given. Small angles in degrees are not noticed.

        Example:
            A calibration of an arm of one joint, with nothing estimated:

            >>> import numpy as np
            >>> from scalar import Calibration, Dataset, Robot, Sensor
            >>> joint = {"a": 0.0, "alpha": 0.0, "d": 0.3, "theta": 0.0}
            >>> robot = Robot.from_mapping({"name": "arm", "joints": [joint]})
            >>> dataset = Dataset.from_arrays(
            ...     robot=robot, sensor=Sensor("tracker", np.eye(4)), q=[[0.0], [1.0]], points=np.eye(2, 3)
            ... )
            >>> calibration = Calibration.nominal(dataset)
            >>> T_base_sensor = calibration.predict([[0.0], [0.5], [1.0]])
            >>> T_base_sensor.shape, float(T_base_sensor[1, 2, 3])
            ((3, 4, 4), 0.3)
        """
        T = self._kinematics(q, columns).T_base_sensor
        return T if target is None else T @ sensor_to_target(self.model, target)

    def correct(self, q: ArrayLike | pd.DataFrame, **columns: ArrayLike) -> Array:
        """Return joint angles ``(N, n)`` [rad] at which the real arm stands where the nominal arm would stand at ``q``.

        This is the inverse of ``predict``, all effects applied: ``predict(correct(q))`` is the nominal arm's flange at ``q`` with the sensor
        as calibrated, to 1e-7 m. An arm with fewer than six joints meets the position, and the orientation as closely as it can. Joint limits
        are not checked; ``scalar.estimation.correction`` says which joints leave them and which poses are near a singularity.

        Args:
            q: As in ``predict``: nominal joint angles.
            columns: As in ``predict``.

        Raises:
            InvalidInput: As in ``predict``, or the arm cannot take a pose near its nominal joint angles (the first such row is named).
        """
        if hasattr(q, "columns"):
            table: Any = q
            self._poses(q, columns)  # refuses degrees
            found = correct_table(self.model, table.assign(**columns))
        else:
            found = correct_joints(self.model, self._poses(q, columns))
        found.refuse_unreached()
        return found.q

    def predict_std(self, q: ArrayLike | pd.DataFrame, **columns: ArrayLike) -> tuple[Array, Array]:
        """Return the standard errors of the predicted poses; fixed parameters are taken as exact.

        Args:
            q: As in ``predict``.
            columns: As in ``predict``.

        Returns:
            Position ``(N,)`` [m] and orientation ``(N,)`` [rad]: root of the trace of each 3 x 3 covariance; NaN if the fit
            gave no covariance.

        Raises:
            InvalidInput: As in ``predict``.
        """
        kinematics = self._kinematics(q, columns)
        deviations = pose_deviations(self.model, kinematics, self.free, self.covariance)
        if deviations is None:
            unknown = np.full(len(kinematics.T_base_sensor), np.nan)
            return unknown, unknown
        return np.linalg.norm(deviations[:, :3], axis=(1, 2)), np.linalg.norm(deviations[:, 3:], axis=(1, 2))

    def predict_covariance(
        self, q: ArrayLike | pd.DataFrame, *, target: str | None = None, **columns: ArrayLike
    ) -> Array:
        """Return the covariances ``(N, 6, 6)`` [m, rad] of the predicted poses; fixed parameters are taken as exact.

        The first three coordinates are a shift of the sensor's origin, the others a small rotation about it, in the base frame. They are NaN if
        the fit gave no covariance.

        Args:
            q: As in ``predict``.
            target: As in ``predict``.
            columns: As in ``predict``.
        """
        kinematics = self._kinematics(q, columns)
        deviations = pose_deviations(self.model, kinematics, self.free, self.covariance, target)
        if deviations is None:
            return np.full((len(kinematics.T_base_sensor), 6, 6), np.nan)
        return deviations @ np.swapaxes(deviations, 1, 2)

    def _poses(self, q: ArrayLike | pd.DataFrame, columns: Mapping[str, ArrayLike]) -> Poses:
        """Return joint angles with the columns that effects need, as poses; joint angles far beyond the limits are refused as degrees."""
        robot = self.model.robot
        if hasattr(q, "columns"):  # a table; asked in this way, an array needs no import of pandas
            table: Any = q
            poses = Poses.from_frame(table.assign(**columns), robot.slides, order_is_row=False)
        else:
            poses = Poses.from_arrays(q, columns, robot.slides)
        refuse_degrees(poses.q, robot.limits, robot.slides)
        return poses

    def _kinematics(self, q: ArrayLike | pd.DataFrame, columns: Mapping[str, ArrayLike]) -> Kinematics:
        """Return the kinematics of the model at joint angles, all effects applied."""
        at = self._poses(q, columns)
        return Kinematics.of(self.model, at, EffectBases.of(self.model.nominal, at, self.model.effects))

    def to_mapping(self) -> dict[str, Any]:
        """Return the content of ``calibration.json``."""
        model = self.model
        return {
            "format": FORMAT,
            "robot": {
                "nominal": model.nominal.to_mapping(),
                "calibrated": model.robot.to_mapping(),
                **standard_dh_mapping(model.nominal),
            },
            "sensor": {**self.sensor, "pose": fixed_transform_mapping(model.T_flange_sensor)},
            "parameters": self.parameters(),
            "gauge": list(self.gauge),
            "effects": [
                effect_to_mapping(effect, std)
                for effect, std in zip(model.effects, self.effect_std, strict=True)
            ],
            "noise": [dict(component) for component in self.noise],
            "residual_rms_m": self.residual_rms,
            "planes": [],
            **kind_named(self.sensor["kind"]).target_to_mapping(model.target, self.std),
            "summary": dict(self.summary),
            "names": list(self.free),
            "covariance": [list(map(float, row)) for row in self.covariance],
        }

    def save(self, path: str | Path) -> None:
        """Write ``calibration.json``, whole or not at all.

        Raises:
            InvalidInput: The place cannot be written.
        """
        write_json(path, self.to_mapping())

    @staticmethod
    def load(path: str | Path) -> Calibration:
        """Return the calibration in a file that ``save`` wrote, of this version of the format or of version 1.

        Raises:
            InvalidInput: The file is missing, is not a calibration, or has what this release does not know.
        """
        return load_calibration(path)


def load_calibration(path: str | Path) -> Calibration:
    """Return the calibration in a file that ``Calibration.save`` wrote.

    Raises:
        InvalidInput: The file is missing, is not JSON, is damaged (the key is named), is not a calibration, or has an effect whose
            module is absent.
    """

    def build(mapping: Mapping[str, Any]) -> Calibration:
        calibration = Calibration(**saved_fields(mapping))
        check_effects_made(calibration.model.effects, mapping, str(path))
        return calibration

    return read_calibration(Path(path), build)
