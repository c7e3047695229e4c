"""Simulate datasets of a robot workcell in pybullet, with the truth behind them.

This is the only part of the package that needs pybullet. It is imported only by the commands that simulate or test for
collisions, and by the studies of the paper. It shares no code with the estimator's model: kinematics and rays are computed by
pybullet, and the matrix computations around them are written again here.

Example::

    config = load_config(Path("configs/scenes/paper.yaml"))
    scene = simulate(config)
    write_scene(scene, Path("out"))
"""

from scalar.simulation.config import load_config
from scalar.simulation.errors import SimulationError
from scalar.simulation.export import write_scene
from scalar.simulation.plan import PosePlan, plan_poses
from scalar.simulation.scene import SimulatedScene, simulate

__all__ = [
    "PosePlan",
    "SimulatedScene",
    "SimulationError",
    "load_config",
    "plan_poses",
    "simulate",
    "write_scene",
]
