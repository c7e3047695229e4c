"""A picture of the workcell: arm, target planes, scan lines and the laser's fan, drawn by pybullet's software renderer.

The picture is for people to look at; no number depends on it. The renderer has hard edges, no transparency, and no soft shadows. So
several views are averaged, with the camera moved by parts of a pixel and the light by a little; shadows come from a
second view, from the light; and the fan is blended in where nothing stands before it.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pybullet

from scalar.simulation.body import body_of
from scalar.simulation.camera import Camera
from scalar.simulation.scanner import directions
from scalar.simulation.scene import SimulatedScene
from scalar.simulation.shapes import Mesh, box, link_shapes, sheet, tube
from scalar.simulation.transforms import Array, rotation_from_quaternion
from scalar.simulation.world import World
from scalar.units import DEG

TARGET_PLANE_COLOURS = ((0.93, 0.94, 0.95), (0.80, 0.87, 0.94), (0.96, 0.90, 0.80))
LINE_COLOURS = ((0.33, 0.36, 0.40), (0.16, 0.38, 0.62), (0.72, 0.45, 0.10))
HOUSING_COLOUR = (0.95, 0.95, 0.93)
JOINT_COLOUR = (0.30, 0.33, 0.38)
SENSOR_COLOUR = (0.12, 0.12, 0.14)
LASER_COLOUR = (0.88, 0.07, 0.10)
FAN_OPACITY = 0.38
LINE_RADIUS = 1.8e-3  # m
LASER_RADIUS = 4.0e-3  # m
LIFT = 2.0e-3  # m, height of the scan lines above their target plane
LIGHT = (-1.0, -1.5, 2.6)  # direction towards the light
LIGHT_SPREAD = 0.12
SHADE = 0.80
SHADOW_PIXELS = 800
# Height [m] above a surface at which its shadow is looked up, so that it does not shade itself.
SHADOW_BIAS = 12e-3
VIEWS = 8
UPRIGHT = 0.5  # a target plane is upright if the z component of its unit normal has at most this magnitude


@dataclass(frozen=True, eq=False)
class Picture:
    """A picture and where things are in it.

    Attributes:
        image: ``(height, width, 3)`` uint8.
        places: ``{name: (x, y) in pixels from the upper left}``, of each target plane's outer edge, the scanner, the base.
    """

    image: Array
    places: dict[str, tuple[float, float]]


def render_scene(
    scene: SimulatedScene,
    row: int | None = None,
    *,
    width: int = 960,
    height: int = 720,
    azimuth_deg: float = 236.0,
    elevation_deg: float = 21.0,
    views: int = VIEWS,
) -> Picture:
    """Return a picture of the arm at one pose of a scene, its laser on, and of all scan lines.

    Args:
        scene: the simulated scene.
        row: row of the poses table; None for a pose whose fan is seen well.
        width, height: in pixels.
        azimuth_deg, elevation_deg: of the camera, seen from the middle of the workcell.
        views: number of views that are averaged.
    """
    workcell = scene.workcell
    corners = np.concatenate([target_plane.solid()[0] for target_plane in workcell.target_planes])
    azimuth, elevation = azimuth_deg * DEG, elevation_deg * DEG
    towards = np.array([np.cos(azimuth), np.sin(azimuth), np.tan(elevation)])
    camera = Camera.fitted(corners, towards, width, height)
    ends = _scan_ends(scene)
    if row is None:
        row = _largest_fan(scene, ends, camera)
    starts = scene.T_base_sensor[:, :3, 3]
    with World() as world, World() as marks, World() as glass:
        for k, target_plane in enumerate(workcell.target_planes):
            face = box(np.array([*target_plane.size, target_plane.thickness]))
            T = np.eye(4)
            T[:3, :3], T[:3, 3] = (
                target_plane.axes,
                target_plane.centre - target_plane.axes[:, 2] * target_plane.thickness / 2,
            )
            _add(world.client, face.moved(T), TARGET_PLANE_COLOURS[k % len(TARGET_PLANE_COLOURS)])
        for k, (first, last) in enumerate(ends):
            target_plane = workcell.target_planes[scene.plane_index[k]]
            colour = LASER_COLOUR if k == row else LINE_COLOURS[scene.plane_index[k] % len(LINE_COLOURS)]
            lift = target_plane.axes[:, 2] * LIFT
            line = tube(first + lift, last + lift, LASER_RADIUS if k == row else LINE_RADIUS, caps=False)
            _add(marks.client, line, colour)
        _show_arm(world, scene, row)
        _add(glass.client, sheet(np.array([starts[row], *ends[row]])), LASER_COLOUR)
        image = _averaged(camera, corners, world.client, marks.client, glass.client, views)
    places = {
        target_plane.name: camera.pixels(_label_point(target_plane)[None])[0]
        for target_plane in workcell.target_planes
    }
    places |= {"scanner": camera.pixels(starts[row : row + 1])[0], "base": camera.pixels(np.zeros((1, 3)))[0]}
    return Picture(image, {name: (float(x), float(y)) for name, (x, y) in places.items()})


def _averaged(camera: Camera, corners: Array, solid: int, marks: int, glass: int, views: int) -> Array:
    """Return the picture (height, width, 3) uint8 of three pybullet clients: solids, marks that cast no shadow, and the transparent fan."""
    rng = np.random.default_rng(0)
    total = np.zeros((camera.height, camera.width, 3))
    for k in range(views):
        # Shifts that fill a pixel evenly (by the golden ratio), lights at random about theirs.
        shift = np.array([(k + 0.5) / views, (k * 0.6180339887498949) % 1.0]) - 0.5
        light = np.array(LIGHT) + LIGHT_SPREAD * np.linalg.norm(LIGHT) * rng.uniform(-1, 1, 3)
        eye = camera.shifted(shift)
        colours, depth = eye.photograph(solid, light)
        lamp = Camera.fitted(corners, light, SHADOW_PIXELS, SHADOW_PIXELS)
        shade = _shaded(eye.points(depth), lamp, lamp.photograph(solid, light)[1]).reshape(depth.shape)
        shade &= depth < 1.0
        colours[shade] *= SHADE
        drawn, before = eye.photograph(marks, light)
        colours[before < depth] = drawn[before < depth]
        seen = (eye.photograph(glass, light)[1] < depth)[..., None] * FAN_OPACITY
        total += (1 - seen) * colours + seen * 255.0 * np.array(LASER_COLOUR)
    return (total / views).round().clip(0, 255).astype(np.uint8)


def _shaded(points: Array, lamp: Camera, depth: Array) -> Array:
    """Return whether something stands between points (N, 3) and the light, ``(N,)`` bool."""
    behind = lamp.clip(points + SHADOW_BIAS * lamp.towards)
    pixels = ((behind[:, :2] * [1, -1] + 1) / 2 * [lamp.width, lamp.height]).astype(int)
    inside = np.all((pixels >= 0) & (pixels < [lamp.width, lamp.height]), axis=1)
    x, y = np.where(inside[:, None], pixels, 0).T
    return inside & (depth[y, x] < (behind[:, 2] + 1) / 2)


def _show_arm(world: World, scene: SimulatedScene, row: int) -> None:
    """Draw the arm where pybullet's kinematics puts its links."""
    workcell = scene.workcell
    world.place_arm(workcell.arm)
    world.move(scene.q_true[row].tolist())
    frames: Mapping[int, Array] = {-1: np.eye(4)} | {
        link: _frame(pybullet.getLinkState(world.arm_id, link, 0, 1, physicsClientId=world.client))
        for link in range(workcell.arm.n + 2)
    }
    colours = {"housing": HOUSING_COLOUR, "joint": JOINT_COLOUR, "sensor": SENSOR_COLOUR}
    for link, kind, mesh in link_shapes(workcell.arm, body_of(workcell.nominal, scene.config["body"])):
        _add(world.client, mesh.moved(frames[link]), colours[kind])


def _frame(state: Any) -> Array:
    T = np.eye(4)
    T[:3, :3] = rotation_from_quaternion(np.array(state[1]))
    T[:3, 3] = state[0]
    return T


def _add(client: int, mesh: Mesh, colour: tuple[float, ...]) -> None:
    shape = pybullet.createVisualShape(
        pybullet.GEOM_MESH,
        vertices=mesh.vertices.tolist(),
        indices=mesh.triangles.ravel().tolist(),
        normals=mesh.normals.tolist(),
        rgbaColor=[*colour, 1.0],
        physicsClientId=client,
    )
    pybullet.createMultiBody(0, baseVisualShapeIndex=shape, physicsClientId=client)


def _scan_ends(scene: SimulatedScene) -> Array:
    """Return the first and the last true point of every scan, (N, 2, 3) [m] in the base frame."""
    outer = [0, -1]
    points = scene.ranges[:, outer, None] * directions(scene.angles[:, outer])
    T = scene.T_base_sensor
    return points @ T[:, :3, :3].transpose(0, 2, 1) + T[:, None, :3, 3]


def _largest_fan(scene: SimulatedScene, ends: Array, camera: Camera) -> int:
    """Return the row of the pose whose fan is seen large, far out and not hidden by the arm; on an upright target plane if there is one."""
    corners = np.concatenate([scene.T_base_sensor[:, None, :3, 3], ends], axis=1)
    x, y = np.moveaxis(camera.pixels(corners.reshape(-1, 3)).reshape(-1, 3, 2), 2, 0)
    area = (x[:, 1] - x[:, 0]) * (y[:, 2] - y[:, 0]) - (x[:, 2] - x[:, 0]) * (y[:, 1] - y[:, 0])
    upright = np.array(
        [abs(float(target_plane.normal[2])) < UPRIGHT for target_plane in scene.workcell.target_planes]
    )[scene.plane_index]
    reach = np.linalg.norm(corners[:, 0, :2], axis=1)
    return int(np.argmax(np.abs(area) * reach * (upright if upright.any() else 1)))


def _label_point(target_plane: Any) -> Array:
    """Return the point of a target plane's face at which its name is written: near the upper edge, or near the +y edge of a floor."""
    return target_plane.centre + target_plane.axes[:, :2] @ (target_plane.size * [0.0, 0.40])
