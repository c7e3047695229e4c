"""Fit with ``scalar.calibrate``: the call of its documentation, for a dataset of arrays."""

from __future__ import annotations

import numpy as np
from exchange import KINDS, Fitted, Job, run

from scalar import Calibration, Dataset, Robot, Sensor, calibrate


def dataset_of(job: Job) -> Dataset:
    """Return the data of a job; the tracker's frame is left for scalar to find."""
    joints = [
        {**dict(zip(KINDS, map(float, row), strict=True)), "limits": limits.tolist()}
        for row, limits in zip(job.dh, job.limits, strict=True)
    ]
    T_flange_reflector = np.eye(4)
    T_flange_reflector[:3, 3] = job.reflector
    return Dataset.from_arrays(
        robot=Robot.from_mapping({"name": "arm", "convention": "modified-dh", "joints": joints}),
        sensor=Sensor("tracker", T_flange_reflector, noise=job.noise),
        q=job.q,
        points=job.measured,
    )


def fitted(calibration: Calibration) -> Fitted:
    """Return what a calibration of such a dataset predicts in the tracker's frame."""
    frames = calibration.model.target

    def predict(q: np.ndarray) -> np.ndarray:
        return calibration.predict(q)[:, :3, 3] @ frames.rotations[0].T + frames.coordinates[0, :3]

    evaluations = calibration.summary["evaluations"]
    return Fitted(predict, len(calibration.free), evaluations, "evaluations", "yes")


def fit(job: Job) -> Fitted:
    """Return the calibration of a job. What to fix is found by scalar itself."""
    return fitted(calibrate(dataset_of(job)))


if __name__ == "__main__":
    run("scalar-calibration", fit)
