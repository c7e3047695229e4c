"""Shapes for pictures, as triangles with normals: tubes with round ends, boxes, sheets, and an arm made of these."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from scalar.simulation.arm import Arm
from scalar.simulation.body import Body, Box, Capsule
from scalar.simulation.transforms import Array

AROUND = 40  # facets of a tube
CAP_RINGS = 8
JOINT_WIDER = 1.22  # radius of a joint's housing over that of the thicker of its links
JOINT_LONG = 1.25  # half the length of a joint's housing, in radii
EDGE = 0.14  # radius of the rounded rim of a joint's housing, over that of the housing


@dataclass(frozen=True, eq=False)
class Mesh:
    """A mesh of triangles.

    Attributes:
        vertices: (V, 3) [m].
        normals: (V, 3), unit vectors.
        triangles: (F, 3), indices of vertices.
    """

    vertices: Array
    normals: Array
    triangles: Array

    def moved(self, T: Array) -> "Mesh":
        """Return the mesh moved by T (4, 4)."""
        R = T[:3, :3]
        return Mesh(self.vertices @ R.T + T[:3, 3], self.normals @ R.T, self.triangles)


def frame_along(start: Array, end: Array) -> Array:
    """Return a frame (4, 4) at `start` with its z towards `end`."""
    z = (end - start) / np.linalg.norm(end - start)
    x = np.cross(np.eye(3)[np.argmin(np.abs(z))], z)
    x = x / np.linalg.norm(x)
    T = np.eye(4)
    T[:3, :3] = np.column_stack([x, np.cross(z, x), z])
    T[:3, 3] = start
    return T


def turned(profile: Array) -> Mesh:
    """Return the solid that a profile (K, 2) of (radius, height) makes when it turns about z, normals outward."""
    along = np.gradient(profile, axis=0)
    out = np.column_stack([along[:, 1], -along[:, 0]])
    out = out / np.maximum(np.linalg.norm(out, axis=1, keepdims=True), 1e-12)
    angle = np.linspace(0, 2 * np.pi, AROUND, endpoint=False)
    c, s = np.cos(angle), np.sin(angle)

    def spun(pairs: Array) -> Array:
        r, z = pairs[:, 0, None], np.repeat(pairs[:, 1, None], AROUND, axis=1)
        return np.stack([r * c, r * s, z], axis=-1).reshape(-1, 3)

    ring = np.arange(AROUND)
    after = (ring + 1) % AROUND
    quads = []
    for k in range(len(profile) - 1):
        a, b = k * AROUND, (k + 1) * AROUND
        quads.append(np.column_stack([a + ring, a + after, b + after]))
        quads.append(np.column_stack([a + ring, b + after, b + ring]))
    return Mesh(spun(profile), spun(out), np.concatenate(quads))


def tube(start: Array, end: Array, radius: float, *, caps: bool = True) -> Mesh:
    """Return a tube.

    Args:
        start: one end of its axis (3,) [m].
        end: the other end (3,) [m].
        radius: [m].
        caps: whether half a sphere closes each end; else the tube is open.
    """
    length = float(np.linalg.norm(end - start))
    profile = np.array([[radius, 0.0], [radius, length]])
    if caps:
        bend = np.linspace(0, np.pi / 2, CAP_RINGS)
        arc = radius * np.column_stack([np.sin(bend), -np.cos(bend)])
        profile = np.concatenate([arc, arc[::-1] * [1, -1] + [0, length]])
    return turned(profile).moved(frame_along(start, end))


def drum(radius: float, half: float) -> Mesh:
    """Return a cylinder about z from -half to half [m] with flat ends and a rounded rim."""
    rim = EDGE * radius
    bend = np.linspace(0, np.pi / 2, CAP_RINGS)
    arc = np.column_stack([radius - rim + rim * np.sin(bend), half - rim + rim * np.cos(bend)])
    upper = np.concatenate([[[1e-4 * radius, half], [0.98 * (radius - rim), half]], arc])
    lower = upper * [1, -1]
    return turned(np.concatenate([lower, upper[::-1]]))


def box(size: Array) -> Mesh:
    """Return a box of `size` (3,) [m] about the origin."""
    vertices, normals, triangles = [], [], []
    for axis in range(3):
        for side in (-1.0, 1.0):
            u, v = np.roll(np.eye(3), -axis - 1, axis=0)[:2]
            n = side * np.eye(3)[axis]
            first = len(vertices)
            vertices += [
                (n + a * u + side * b * v) * size / 2 for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))
            ]
            normals += [n] * 4
            triangles += [(first, first + 1, first + 2), (first, first + 2, first + 3)]
    return Mesh(np.array(vertices), np.array(normals), np.array(triangles))


def sheet(corners: Array) -> Mesh:
    """Return a triangle (3, 3) [m], seen from both sides."""
    normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
    normal = normal / np.linalg.norm(normal)
    return Mesh(
        np.concatenate([corners, corners]),
        np.array([normal] * 3 + [-normal] * 3),
        np.array([(0, 1, 2), (3, 5, 4)]),
    )


def link_shapes(arm: Arm, body: Body) -> Iterator[tuple[int, str, Mesh]]:
    """Yield (link, kind, mesh in the link's frame): a body's solids, and a housing about the axis of every joint.

    Kinds are ``housing``, ``joint`` and ``sensor``; links count as in ``scalar.simulation.body``.
    """
    thickness: dict[int, float] = {}
    for solid in body.solids:
        if isinstance(solid, Box):
            T = np.eye(4)
            T[:3, 3] = solid.centre
            yield solid.link, "sensor", box(solid.size).moved(T)
            continue
        kind = "joint" if solid.link >= arm.n else "housing"
        thickness[solid.link] = max(thickness.get(solid.link, 0.0), solid.radius)
        yield solid.link, kind, _capsule(solid)
    widest = max(thickness.values())
    for i in range(arm.n):
        radius = JOINT_WIDER * max(thickness.get(i - 1, 0.0), thickness.get(i, 0.0))
        yield i, "joint", drum(radius, JOINT_LONG * radius * (0.55 if radius < 0.7 * widest else 1.0))
    T = np.eye(4)
    T[2, 3] = 0.25 * widest
    yield -1, "joint", drum(1.9 * widest, 0.25 * widest).moved(T)


def _capsule(solid: Capsule) -> Mesh:
    return tube(solid.start, solid.end, solid.radius)
