"""A picture of the cell: arm, plates and the laser's fan, drawn by pybullet's software renderer.

For people to look at; no number depends on it.
"""

import numpy as np
import pybullet

from scalar.simulation.body import body_of
from scalar.simulation.plates import Plate
from scalar.simulation.scanner import BEYOND, cast_fan, directions
from scalar.simulation.scene import SimulatedScene
from scalar.simulation.transforms import Array, quaternion_from_rotation
from scalar.simulation.world import World

PLATE_COLOURS = ((0.78, 0.80, 0.84, 1.0), (0.90, 0.84, 0.74, 1.0), (0.76, 0.86, 0.80, 1.0))
ARM_COLOURS = ((0.26, 0.36, 0.52, 1.0), (0.45, 0.56, 0.72, 1.0))
SENSOR_COLOUR = (0.15, 0.15, 0.17, 1.0)
LASER_COLOUR = (0.86, 0.10, 0.10, 1.0)
FAN_RAYS = 41
BEAM_RADIUS = 1.2e-3  # m
SPOT_RADIUS = 4.0e-3  # m
FIELD_OF_VIEW_DEG = 38.0
SUPERSAMPLING = 2  # drawn larger and averaged, since the renderer does not smooth edges


def render_scene(
    scene: SimulatedScene, row: int = 0, *, width: int = 960, height: int = 720, azimuth_deg: float = 215.0
) -> Array:
    """Return a picture (height, width, 3) uint8 of the arm at pose `row` of a scene, with its laser on.

    Args:
        scene: simulated. row: of the poses table. azimuth_deg: direction from the middle of the cell to the
            camera, about z.
    """
    cell = scene.cell
    with World(cell.plates) as world:
        client = world.client
        world.place_arm(cell.arm, body_of(cell.drawn, scene.config["body"]))
        T = world.sensor_frames(scene.q[row : row + 1])
        for k, plate in enumerate(cell.plates):
            _show_plate(plate, PLATE_COLOURS[k % len(PLATE_COLOURS)], client)
        for link in range(-1, cell.arm.n + 2):
            colour = SENSOR_COLOUR if link >= cell.arm.n else ARM_COLOURS[link % 2]
            pybullet.changeVisualShape(world.arm_id, link, rgbaColor=colour, physicsClientId=client)
        angles = np.linspace(-cell.scanner.fan, cell.scanner.fan, FAN_RAYS)
        _, ranges = cast_fan(world, T, angles, cell.scanner.range_far * BEYOND)
        ends = T[0, :3, 3] + (ranges[0, :, None] * directions(angles)) @ T[0, :3, :3].T
        for end in ends:
            _beam(T[0, :3, 3], end, client)
        return _photograph(_middle(scene), width, height, azimuth_deg, client)


def _show_plate(plate: Plate, colour: tuple[float, ...], client: int) -> None:
    """Draw a plate as a box: the triangles that rays meet are not drawn by pybullet."""
    half = [*(plate.size / 2), plate.thickness / 2]
    box = pybullet.createVisualShape(
        pybullet.GEOM_BOX, halfExtents=half, rgbaColor=colour, physicsClientId=client
    )
    pybullet.createMultiBody(
        0,
        baseVisualShapeIndex=box,
        basePosition=(plate.centre - plate.axes[:, 2] * plate.thickness / 2).tolist(),
        baseOrientation=quaternion_from_rotation(plate.axes).tolist(),
        physicsClientId=client,
    )


def _beam(start: Array, end: Array, client: int) -> None:
    """Draw one ray, and a spot where it ends."""
    along = end - start
    length = float(np.linalg.norm(along))
    z = along / length
    x = np.cross(np.eye(3)[np.argmin(np.abs(z))], z)
    x = x / np.linalg.norm(x)
    quaternion = quaternion_from_rotation(np.column_stack([x, np.cross(z, x), z]))
    ray = pybullet.createVisualShape(
        pybullet.GEOM_CYLINDER,
        radius=BEAM_RADIUS,
        length=length,
        rgbaColor=LASER_COLOUR,
        physicsClientId=client,
    )
    pybullet.createMultiBody(
        0,
        baseVisualShapeIndex=ray,
        basePosition=((start + end) / 2).tolist(),
        baseOrientation=quaternion.tolist(),
        physicsClientId=client,
    )
    spot = pybullet.createVisualShape(
        pybullet.GEOM_SPHERE, radius=SPOT_RADIUS, rgbaColor=LASER_COLOUR, physicsClientId=client
    )
    pybullet.createMultiBody(0, baseVisualShapeIndex=spot, basePosition=end.tolist(), physicsClientId=client)


def _middle(scene: SimulatedScene) -> tuple[Array, float]:
    """Return the middle of the cell (3,) [m] and its size [m]: of base, shoulder and plates."""
    arm = scene.cell.drawn
    shoulder = (arm.T_base_0 @ arm.joint_origin(0))[:3, 3]
    points = np.array([np.zeros(3), shoulder, *(plate.centre for plate in scene.cell.plates)])
    middle = (points.min(0) + points.max(0)) / 2
    return middle, float(max(plate.size.max() for plate in scene.cell.plates))


def _photograph(view: tuple[Array, float], width: int, height: int, azimuth_deg: float, client: int) -> Array:
    target, radius = view
    camera = pybullet.computeViewMatrixFromYawPitchRoll(
        cameraTargetPosition=target.tolist(),
        distance=2.0 * radius,
        yaw=azimuth_deg - 270.0,
        pitch=-24.0,
        roll=0.0,
        upAxisIndex=2,
        physicsClientId=client,
    )
    lens = pybullet.computeProjectionMatrixFOV(
        FIELD_OF_VIEW_DEG, width / height, 0.05, 10.0 * radius, physicsClientId=client
    )
    _, _, pixels, _, _ = pybullet.getCameraImage(
        width * SUPERSAMPLING,
        height * SUPERSAMPLING,
        camera,
        lens,
        lightDirection=[-1.0, -1.5, 3.0],
        shadow=1,
        lightAmbientCoeff=0.65,
        lightDiffuseCoeff=0.45,
        lightSpecularCoeff=0.1,
        renderer=pybullet.ER_TINY_RENDERER,
        physicsClientId=client,
    )
    shape = (height, SUPERSAMPLING, width, SUPERSAMPLING, 4)
    image = np.asarray(pixels, np.uint8).reshape(shape)[..., :3]
    return image.mean((1, 3)).round().astype(np.uint8)
