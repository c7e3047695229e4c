"""Fit with pybotics as its example of a calibration does: ``least_squares`` of SciPy over the vector of an ``OptimizationHandler``.

World and tool can be given and fitted. Lengths are in millimetres, as in the models of pybotics. Its table has no Hayati angle.
"""

from __future__ import annotations

import numpy as np
from exchange import KINDS, Fitted, Job, run
from pybotics.kinematic_chain import MDHKinematicChain
from pybotics.optimization import OptimizationHandler, optimize_accuracy
from pybotics.robot import Robot
from pybotics.tool import Tool
from scipy.optimize import OptimizeResult, least_squares


def handler_of(job: Job) -> OptimizationHandler:
    """Return the nominal arm with the parameters that are free.

    Free are the tracker's frame, the place of the reflector and the table, less what would repeat these: the first joint's row moves the base,
    theta and d of the last one move the reflector, and d of the second joint is that of the third, parallel one.
    """
    dh, world, tool = job.dh.copy(), job.T_tracker_base.copy(), np.eye(4)
    dh[:, [KINDS.index("a"), KINDS.index("d")]] /= job.millimetre
    world[:3, 3] /= job.millimetre
    tool[:3, 3] = job.reflector / job.millimetre
    free = np.ones(job.dh.shape, dtype=bool)
    free[0] = False
    free[-1, 2:] = False
    free[1, 3] = False
    arm = Robot(kinematic_chain=MDHKinematicChain(dh.ravel()), tool=Tool(matrix=tool), world_frame=world)
    return OptimizationHandler(
        arm,
        kinematic_chain_mask=free.ravel(),
        tool_mask=[True] * 3 + [False] * 3,
        world_mask=[True] * 6,
    )


def fit(job: Job) -> Fitted:
    """Return the calibrated arm. What is minimised are the distances of the positions, one for each pose."""
    handler = handler_of(job)
    found = least_squares(
        fun=optimize_accuracy,
        x0=handler.generate_optimization_vector(),
        args=(handler, job.q, job.measured / job.millimetre),
    )
    return fitted(handler, found, job.millimetre)


def fitted(handler: OptimizationHandler, found: OptimizeResult, millimetre: float) -> Fitted:
    """Return the arm of a handler at what ``least_squares`` found; a millimetre is in metres."""
    handler.apply_optimization_vector(found.x)

    def predict(q: np.ndarray) -> np.ndarray:
        return np.array([handler.robot.fk(each)[:3, 3] for each in q]) * millimetre

    return Fitted(predict, len(found.x), found.nfev, "steps", "no")


if __name__ == "__main__":
    run("pybotics", fit)
