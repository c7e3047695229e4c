"""Fit with figaroh by its default, the structural choice of parameters, from a URDF, a table and a configuration in its unified format.

It estimates the tracker's frame and the reflector's place, both from a start of its own. The class follows the one of its UR10 example, and
the tool's frame is the arm's last one, as there.
"""

from __future__ import annotations

import contextlib
import io
import tempfile
from pathlib import Path

import numpy as np
import pandas as pd
import pinocchio
import yaml
from arm_urdf import FLANGE, urdf
from exchange import Fitted, Job, run
from figaroh.calibration.base_calibration import BaseCalibration
from figaroh.calibration.calibration_tools import calc_updated_fkm

DEGREES_OF_FREEDOM = [True, True, True, False, False, False]  # a position is measured, and no orientation


class TrackedArm(BaseCalibration):
    """An arm of which a tracker measures positions, all with the same noise."""

    def cost_function(self, var: np.ndarray) -> np.ndarray:
        """Return the residuals ``(3N,)`` [m]."""
        estimated = calc_updated_fkm(self.model, self.data, var, self.q_measured, self.calib_config)
        return self.apply_measurement_weighting(
            self._compute_logmap_residuals(self.PEE_measured, estimated), pos_weight=1.0, orient_weight=1.0
        )


def configuration(job: Job, estimation: dict) -> dict:
    """Return the content of the configuration file."""
    task = {
        "enabled": True,
        "parameters": {"calibration_level": "full_params", "estimation": estimation},
        "kinematics": {"base_frame": "universe", "tool_frame": FLANGE},
        "measurements": {
            "markers": [
                {
                    "name": "reflector",
                    "reference_joint": f"joint{len(job.dh)}",
                    "measurable_dof": DEGREES_OF_FREEDOM,
                }
            ],
            "poses": {"base_pose": [0.0] * 6, "tool_pose": [*job.reflector.tolist(), 0.0, 0.0, 0.0]},
        },
        "data": {"source_file": "data.csv", "number_of_samples": len(job.q)},
    }
    return {"robot": {"name": "arm"}, "tasks": {"calibration": task}}


def prepared(job: Job, folder: Path, estimation: dict) -> TrackedArm:
    """Return the calibration of the files in a folder, which are written."""
    (folder / "arm.urdf").write_text(urdf(job), encoding="utf-8")
    columns = {f"joint{i + 1}": job.q[:, i] for i in range(job.q.shape[1])}
    positions = dict(zip(("x1", "y1", "z1"), job.measured.T, strict=True))
    pd.DataFrame(positions | columns).to_csv(folder / "data.csv", index=False)
    settings = configuration(job, estimation)
    settings["tasks"]["calibration"]["data"]["source_file"] = str(folder / "data.csv")
    (folder / "arm.yaml").write_text(yaml.safe_dump(settings), encoding="utf-8")
    arm = pinocchio.RobotWrapper(pinocchio.buildModelFromUrdf(str(folder / "arm.urdf")))
    calibration = TrackedArm(arm, str(folder / "arm.yaml"))
    calibration.calib_config["known_baseframe"] = False
    calibration.calib_config["known_tipframe"] = False
    return calibration


def fit(job: Job, **estimation) -> Fitted:
    """Return the calibrated arm.

    Args:
        job: The task.
        **estimation: Section ``estimation`` of figaroh's configuration; by default its default.
    """
    with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(io.StringIO()):
        calibration = prepared(job, Path(folder), estimation)
        calibration.initialize()
        found = calibration.solve(enable_logging=False)
    calibration.calc_stddev(found)

    def predict(q: np.ndarray) -> np.ndarray:
        settings = dict(calibration.calib_config, NbSample=len(q))
        flat = calc_updated_fkm(calibration.model, calibration.data, found.x, q, settings)
        return flat.reshape(3, len(q)).T

    return Fitted(predict, len(found.x), found.nfev, "evaluations", "yes")


if __name__ == "__main__":
    run("figaroh", fit)
