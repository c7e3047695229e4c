"""Calibrate simulated workcells, predict poses inside and outside of the measured region, and count how many ellipsoids hold the true position.

A calibration states the covariance of a pose in a frame in which the parameters that no measurement determines are exact (`predict --std`). The true
arm of a workcell therefore has the nominal values of these; every other parameter of its table errs by its tolerance. The arm is simulated without
the estimator's formulas.
"""

from __future__ import annotations

from dataclasses import asdict, replace
from time import process_time
from typing import Any

import numpy as np
import pandas as pd
from scipy.stats import chi2

from scalar.data.dataset import Dataset
from scalar.data.declared import PlaneGuess, Sensor
from scalar.errors import ScalarError
from scalar.estimation.calibrate import calibrate
from scalar.estimation.result import Calibration
from scalar.geometry.robot import Robot, Tolerance
from scalar.robots import read_arm
from scalar.units import MM
from study.common.kinematics import PARAMETER_KINDS, random_transform
from study.coverage.design import SCANNER, Case, Design
from study.spoiled_setups.campaign import flange_frames, geometry_of, with_geometry
from study.spoiled_setups.workcell import (
    GUESS_OFFSET,
    PLANES,
    SCANNER_MOUNT,
    TARGET_MOUNT,
    OutOfReach,
    angles_seeing,
    floor_and_walls,
    leaning,
    random_angles,
    scans,
)

DRAWN = ("number", "sensor", "size", "prior", "arm", "poses", "noise_m")
COLUMNS = {
    **{name: "the attribute of study.coverage.design.Case" for name in DRAWN},
    "region": "inside or outside of the measured ranges of the joints",
    "status": "calibrated, or the class of the error that ended the calibration",
    "predicted": "number of predicted poses",
    "held": "number of those whose true position lies within the 95 % ellipsoid",
    "error_rms_mm": "RMS position error over them",
    "std_rms_mm": "RMS of their stated standard errors",
    "kept": "number of parameters that the calibration keeps near the data sheet",
    "seconds": "processor time of the workcell",
}
LEVEL = 0.95
MOST_ROUNDS = 4  # of finding which parameters are fixed
ROWS = PARAMETER_KINDS[:4]  # beta is no parameter of a table


def run_workcells(design: Design, numbers: range) -> pd.DataFrame:
    """Return two rows for each workcell, columns ``COLUMNS``."""
    rows: list[dict[str, Any]] = []
    for number in numbers:
        new = run_workcell(design, number)
        rows += new
        print(f"{number}: {new[0]['status']}, {[row['held'] for row in new]}", flush=True)
    return pd.DataFrame(rows).reindex(columns=list(COLUMNS))


def run_workcell(design: Design, number: int) -> list[dict[str, Any]]:
    """Return the rows of one workcell: poses inside, and poses outside of the measured region."""
    start = process_time()
    for attempt in range(100):
        case, rng = design.drawn(number, attempt)
        try:
            campaign = Measured(case, rng)
        except OutOfReach:
            continue
        key = {name: asdict(case)[name] for name in DRAWN}
        try:
            calibration = campaign.calibrated()
        except ScalarError as error:
            failed = key | {"status": type(error).__name__, "seconds": process_time() - start}
            return [failed | {"region": region} for region in ("inside", "outside")]
        rows = []
        for region in ("inside", "outside"):
            found = campaign.counted(calibration, region, rng)
            rows.append(key | found | {"region": region, "seconds": process_time() - start})
        return rows
    raise AssertionError(f"workcell {number}: no arm reaches the planes")


class Measured:
    """A simulated workcell that is measured anew with another true arm at the same poses."""

    def __init__(self, case: Case, rng: np.random.Generator) -> None:
        """Draw the errors of the table, the poses and the noise.

        Raises:
            OutOfReach: The arm hardly reaches the planes.
        """
        self.case = case
        self.nominal: dict[str, Any] = dict(read_arm(case.arm).mapping)
        geometry = geometry_of(self.nominal)
        size = np.array([case.length_std_m, case.angle_std_rad] * 2 + [0.0])[:, None]
        self.errors = size * rng.standard_normal(geometry.shape)
        self.limits = np.array([joint["limits"] for joint in self.nominal["joints"]], dtype=float)
        self.scanning = case.sensor == SCANNER
        mount = SCANNER_MOUNT if self.scanning else TARGET_MOUNT
        self.T_flange_sensor = mount @ random_transform(rng, 3e-3, 0.02)
        self.declared = self.T_flange_sensor @ random_transform(rng, 3e-3, 0.02)
        self.T_tracker_base = random_transform(rng, 2.0, 2.0)
        reach = float(np.hypot(geometry[0], geometry[2]).sum())
        self.normals, self.distances = floor_and_walls(rng, reach)
        self.index = rng.permutation(np.arange(case.poses) % len(PLANES))
        self.guesses = [
            PlaneGuess(name, leaning(rng, n), float(d + GUESS_OFFSET * rng.normal()))
            for name, n, d in zip(PLANES, self.normals, self.distances, strict=True)
        ]
        self.q = (
            angles_seeing(
                rng, self.true, self.T_flange_sensor, self.limits, self.normals, self.distances, self.index, case.share
            )
            if self.scanning
            else random_angles(rng, self.limits, case.poses, case.share)
        )  # fmt: skip
        self.noise_seed = int(rng.integers(2**31))

    @property
    def true(self) -> dict[str, Any]:
        """Return the ``robot:`` block with the true numbers."""
        return with_geometry(self.nominal, geometry_of(self.nominal) + self.errors)

    def dataset(self) -> Dataset:
        """Return what is measured."""
        case, rng = self.case, np.random.default_rng(self.noise_seed)
        robot = Robot.from_mapping(self.nominal)
        if case.prior == "stated":
            robot = replace(robot, tolerance=Tolerance(case.length_std_m, case.angle_std_rad))
        frames = flange_frames(self.true, self.q) @ self.T_flange_sensor
        if self.scanning:
            points = scans(rng, frames, self.normals[self.index], self.distances[self.index], case.noise_m)
            return Dataset.from_arrays(
                robot=robot,
                sensor=Sensor(case.sensor, self.declared, case.noise_m, "ray"),
                q=self.q,
                points=list(points),
                planes=self.guesses,
                plane=[PLANES[k] for k in self.index],
            )
        places = (self.T_tracker_base @ frames)[:, :3, 3]
        places = places + case.noise_m * rng.standard_normal(places.shape)
        sensor = Sensor(case.sensor, self.declared, case.noise_m)
        return Dataset.from_arrays(robot=robot, sensor=sensor, q=self.q, points=places)

    def calibrated(self) -> Calibration:
        """Return the calibration of an arm that has the nominal values of all parameters that are fixed.

        Raises:
            ScalarError: The calibration fails.
        """
        for _ in range(MOST_ROUNDS):
            calibration = calibrate(self.dataset())
            fixed = np.array(
                [
                    [f"{kind}_{j + 1}" not in calibration.free for j in range(len(self.limits))]
                    for kind in ROWS
                ]
            )
            wrong = fixed & (self.errors[: len(ROWS)] != 0.0)
            if not wrong.any():
                return calibration
            self.errors[: len(ROWS)][wrong] = 0.0
        raise AssertionError("the parameters that are fixed depend on the errors of the arm")

    def counted(self, calibration: Calibration, region: str, rng: np.random.Generator) -> dict[str, Any]:
        """Return the columns on predictions ``inside`` or ``outside`` of the measured region."""
        q = self.angles(region, rng)
        true = (flange_frames(self.true, q) @ self.T_flange_sensor)[:, :3, 3]
        error = true - calibration.predict(q)[:, :3, 3]
        covariance = calibration.predict_covariance(q)[:, :3, :3]
        squared = np.einsum("ni,nij,nj->n", error, np.linalg.pinv(covariance, hermitian=True), error)
        return {
            "status": "calibrated",
            "predicted": len(q),
            "held": int(np.sum(squared < chi2.ppf(LEVEL, 3))),
            "error_rms_mm": float(np.sqrt(np.mean(np.sum(error**2, axis=1)))) / MM,
            "std_rms_mm": float(np.sqrt(np.mean(np.trace(covariance, axis1=1, axis2=2)))) / MM,
            "kept": len(calibration.summary.get("kept_near_data_sheet") or ()),
        }

    def angles(self, region: str, rng: np.random.Generator) -> np.ndarray:
        """Return joint angles ``(M, n)`` [rad] all within the measured ranges, or each with a joint beyond them."""
        low, high = self.q.min(axis=0), self.q.max(axis=0)
        count = self.case.predicted
        if region == "inside":
            return rng.uniform(low, high, (count, len(low)))
        found: list[np.ndarray] = []
        while len(found) < count:
            tried = random_angles(rng, self.limits, count)
            found.extend(tried[np.any((tried < low) | (tried > high), axis=1)])
        return np.array(found[:count])
