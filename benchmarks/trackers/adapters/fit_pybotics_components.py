"""Fit the arm of pybotics by the three components of each error, in place of its distance, which is what pybotics offers itself.

The optimum is the same. A distance has no derivative where it is zero, so steps by distances come near the optimum slowly.
"""

from __future__ import annotations

import numpy as np
from exchange import Fitted, Job, run
from fit_pybotics import fitted, handler_of
from scipy.optimize import least_squares


def fit(job: Job) -> Fitted:
    """Return the calibrated arm; residuals [mm] are three for each pose, and parameters are scaled by the Jacobian."""
    handler = handler_of(job)
    measured = (job.measured / job.millimetre).ravel()

    def residual(x: np.ndarray) -> np.ndarray:
        handler.apply_optimization_vector(x)
        return np.concatenate([handler.robot.fk(q)[:3, 3] for q in job.q]) - measured

    found = least_squares(residual, handler.generate_optimization_vector(), x_scale="jac")
    return fitted(handler, found, job.millimetre)


if __name__ == "__main__":
    run("pybotics", fit)
