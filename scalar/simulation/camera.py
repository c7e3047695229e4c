"""A camera in pybullet's software renderer: what it sees, how far away that is, and where a point appears."""

from dataclasses import dataclass, replace

import numpy as np
import pybullet

from scalar.simulation.transforms import Array
from scalar.units import DEG

FIELD_OF_VIEW_DEG = 24.0
# Least and largest depth that is drawn, over the camera's distance from its target.
NEAREST, FARTHEST = 0.3, 3.0
MARGIN = 1.04  # size of the picture over that of the points that it has to show
AMBIENT, DIFFUSE, SPECULAR = 0.66, 0.40, 0.08


@dataclass(frozen=True, eq=False)
class Camera:
    """A camera.

    Attributes:
        view: ``(4, 4)``, base frame to camera frame.
        lens: ``(4, 4)``, projection of the camera frame.
        width, height: of the picture [pixels].
    """

    view: Array
    lens: Array
    width: int
    height: int

    @classmethod
    def of(cls, target: Array, towards: Array, distance: float, width: int, height: int) -> "Camera":
        """Return a camera at `distance` [m] from `target` (3,), in the direction `towards` (3,), z upright."""
        eye = target + distance * towards / np.linalg.norm(towards)
        view = pybullet.computeViewMatrix(eye.tolist(), target.tolist(), [0.0, 0.0, 1.0])
        lens = pybullet.computeProjectionMatrixFOV(
            FIELD_OF_VIEW_DEG, width / height, NEAREST * distance, FARTHEST * distance
        )
        return cls(np.reshape(view, (4, 4)).T, np.reshape(lens, (4, 4)).T, width, height)

    @classmethod
    def fitted(cls, points: Array, towards: Array, width: int, height: int) -> "Camera":
        """Return a camera in a direction that just sees all points (N, 3)."""
        target, distance = (points.min(0) + points.max(0)) / 2, 10.0
        for _ in range(4):  # each round finds the middle of the points, and how near the camera may come
            camera = cls.of(target, towards, distance, width, height)
            seen = camera.pixels(points)
            off = (seen.min(0) + seen.max(0)) / 2 - [width / 2, height / 2]
            pixel = 2 * distance * np.tan(FIELD_OF_VIEW_DEG * DEG / 2) / height  # in metres, at the target
            target = target + camera.view[:2, :3].T @ (off * [pixel, -pixel])
            distance *= float((np.ptp(seen, axis=0) / [width, height]).max()) * MARGIN
        return cls.of(target, towards, distance, width, height)

    def clip(self, points: Array) -> Array:
        """Return the normalised device coordinates (N, 3) of points (N, 3) [m] of the base frame: all within -1..1 if the camera sees the point."""
        seen = np.column_stack([points, np.ones(len(points))]) @ (self.lens @ self.view).T
        return seen[:, :3] / seen[:, 3:]

    def pixels(self, points: Array) -> Array:
        """Return the pixel coordinates (N, 2) of points (N, 3) [m] of the base frame, counted from the picture's upper left corner."""
        return (self.clip(points)[:, :2] * [1, -1] + 1) / 2 * [self.width, self.height]

    def shifted(self, pixels: Array) -> "Camera":
        """Return the camera with its picture moved by (2,) pixels."""
        lens = self.lens.copy()
        lens[:2, 2] += 2 * pixels / [self.width, self.height]
        return replace(self, lens=lens)

    def photograph(self, client: int, light: Array) -> tuple[Array, Array]:
        """Return colours (height, width, 3) and depths (height, width)."""
        _, _, pixels, depth, _ = pybullet.getCameraImage(
            self.width,
            self.height,
            self.view.T.ravel().tolist(),
            self.lens.T.ravel().tolist(),
            lightDirection=light.tolist(),
            lightColor=[1.0, 1.0, 1.0],
            shadow=0,
            lightAmbientCoeff=AMBIENT,
            lightDiffuseCoeff=DIFFUSE,
            lightSpecularCoeff=SPECULAR,
            renderer=pybullet.ER_TINY_RENDERER,
            physicsClientId=client,
        )
        shape = (self.height, self.width)
        return np.reshape(pixels, (*shape, 4))[..., :3].astype(float), np.reshape(depth, shape).astype(float)

    def points(self, depth: Array) -> Array:
        """Return the points (height * width, 3) [m] that a picture's depths show."""
        x = (np.arange(self.width) + 0.5) / self.width * 2 - 1
        y = 1 - (np.arange(self.height) + 0.5) / self.height * 2
        grid = np.stack([*np.meshgrid(x, y), 2 * depth - 1, np.ones_like(depth)], axis=-1).reshape(-1, 4)
        found = grid @ np.linalg.inv(self.lens @ self.view).T
        return found[:, :3] / found[:, 3:]

    @property
    def towards(self) -> Array:
        """Return the direction (3,) from what the camera looks at to the camera."""
        return self.view[2, :3]
