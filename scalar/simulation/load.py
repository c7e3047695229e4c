"""Torques that the drives have to hold at each pose: of the arm's weight, by the engine's inverse dynamics, and of a payload's, by virtual work."""

import numpy as np
import pandas as pd

from scalar.simulation.transforms import Array
from scalar.simulation.world import World

G = 9.81  # m/s^2; a payload's weight is taken along -z of the base, whatever gravity the scene has
STEP = 1e-4  # rad; step of central differences
PAYLOAD = "payload"
PLACE = ("payload_x", "payload_y", "payload_z")


def payload_torques(world: World, T_flange_sensor: Array, q: Array, poses: pd.DataFrame) -> Array:
    """Return the torque of the payload's weight about each joint (N, n) [N m]; zero where none is recorded.

    By virtual work, tau_j = -dU/dq_j with U = m g z, where z is the height of the payload's centre of mass by the engine's kinematics.

    Args:
        world: the engine with the arm.
        T_flange_sensor: the sensor's pose on the flange (4, 4).
        q: joint angles (N, n) [rad].
        poses: the table of poses, with the payload's mass [kg] and place on the flange [m] where they are recorded.
    """
    torques = np.zeros_like(q)
    mass = poses[PAYLOAD].to_numpy(float) if PAYLOAD in poses else np.zeros(len(q))
    if not mass.any():
        return torques
    place = np.c_[poses[list(PLACE)].to_numpy(float), np.ones(len(q))]
    in_sensor = place @ np.linalg.inv(T_flange_sensor).T
    weight = G * mass
    for j in range(q.shape[1]):
        step = np.zeros(q.shape[1])
        step[j] = STEP
        up, down = (np.einsum("nj,nj->n", world.sensor_frames(q + s)[:, 2], in_sensor) for s in (step, -step))
        torques[:, j] = -weight * (up - down) / (2 * STEP)
    return torques


def held_torques(world: World, T_flange_sensor: Array, q: Array, poses: pd.DataFrame) -> dict[str, Array]:
    """Return the columns tau1.. of poses.csv (N,) [N m]: the drives' torques that hold arm and payload against their weight.

    The arguments are those of `payload_torques`.
    """
    torques = world.gravity_torques(q) + payload_torques(world, T_flange_sensor, q, poses)
    return {f"tau{j + 1}": -column for j, column in enumerate(torques.T)}
