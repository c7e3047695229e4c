"""Fit with robotkinecal: screws by the product of exponentials, from positions alone.

It has no frame of a measuring device and no tool. The nominal arm is given in the tracker's frame, and the reflector as its end effector; free
axes of all joints then include the tracker's frame, and the end effector's position the reflector.
"""

from __future__ import annotations

import contextlib
import io

import numpy as np
from exchange import Fitted, Job, link, run
from roboticstoolbox import ET, Link, Robot
from robotkinecal import SerialRobotKineCal

END = "reflector"


def arm(job: Job) -> Robot:
    """Return the nominal arm, whose first link stands in the tracker's frame and whose last one is the reflector."""
    before, links = job.T_tracker_base, []
    for i, (alpha, a, theta, d) in enumerate(job.dh):
        place = before @ link(alpha, a, 0.0, 0.0)
        links.append(Link(ET.SE3(place) * ET.Rz(), name=f"link{i + 1}", parent=links[-1] if links else None))
        before = link(0.0, 0.0, theta, d)
    last = before.copy()
    last[:3, 3] += last[:3, :3] @ job.reflector
    return Robot([*links, Link(ET.SE3(last), name=END, parent=links[-1])])


def fit(job: Job) -> Fitted:
    """Return the calibrated arm."""
    calibration = SerialRobotKineCal(arm(job), END)
    calibration.set_observations(list(job.q), list(job.measured))
    with contextlib.redirect_stdout(io.StringIO()):
        result = calibration.solve()

    def predict(q: np.ndarray) -> np.ndarray:
        last = calibration.N_JOINTS + 1
        return np.array([calibration.forward_kinematics(last, each).t for each in q])

    return Fitted(
        predict,
        calibration.N_PARAMS,
        result.nb_iterations_executed,
        "iterations",
        "one number a joint",
    )


if __name__ == "__main__":
    run("robotkinecal", fit)
