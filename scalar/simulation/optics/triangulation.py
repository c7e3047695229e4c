"""A scanner's camera, which looks at the laser's plane from the side: how its noise grows with distance, and the errors of its lens after correction.

The camera stands `BASELINE` beside the laser's plane and `BEHIND` behind the rays' origin, its axis through the middle of the
range. A point (x, 0, z) of the plane is seen at u = X / Z, v = Y / Z; a displacement of its picture moves the point that
is reconstructed along the plane.
"""

from dataclasses import dataclass

import numpy as np

from scalar.simulation.scanner import Scanner
from scalar.simulation.transforms import Array

BASELINE = 0.12  # m
BEHIND = 0.20  # m
MOST = 0.95  # share of the field with errors below the stated size; the corners have larger ones
GRID = 41  # points along each side of the field, to which offset, tilt and gain are fitted, as in a calibration at the factory
# Standard deviations of Brown and Conrady's k1, k2 and p1, p2 over a field of unit radius.
RADIAL, TANGENTIAL = (1.0, 1.0), (0.5, 0.5)
# The most half waves of uncorrected image sensor and window errors along each side of the picture.
RIPPLES = 3
RIPPLE = 0.4  # standard deviation of the amplitude of each


def growth(scanner: Scanner, depth: Array, cosines: Array, shot_share: float) -> Array:
    """Return the ratio (...) of the noise to that in the middle of the range at normal incidence.

    One pixel of the picture corresponds to a depth that grows with the square of the distance to the camera. The light limits how well the position
    in the picture is measured: sigma_v^2 = electronics + shot / light, and the light falls with the square of the distance and with
    the cosine of incidence.

    Args:
        depth: z (...) [m].
        cosines: of incidence (...).
        shot_share: share of shot noise in the variance in the middle.
    """
    middle = (scanner.range_near + scanner.range_far) / 2
    distance = (depth + BEHIND) / (middle + BEHIND)
    return distance**2 * np.sqrt(1.0 - shot_share + shot_share * distance**2 / cosines)


@dataclass(frozen=True, eq=False)
class Linearity:
    """A lens's distortion after the maker's correction of offset, tilt and gain.

    Attributes:
        size: the 95 % quantile of the error in z over the field [m].
        scanner: the scanner with this field.
        lens: (4,) k1, k2, p1, p2.
        ripples: (2, RIPPLES, RIPPLES) amplitudes of half waves in u and v.
    """

    size: float
    scanner: Scanner
    lens: Array
    ripples: Array

    @classmethod
    def drawn(cls, size: float, scanner: Scanner, rng: np.random.Generator) -> "Linearity":
        """Return the distortion of one scanner, drawn at random."""
        lens = rng.standard_normal(4) * [*RADIAL, *TANGENTIAL]
        return cls(size, scanner, lens, RIPPLE * rng.standard_normal((2, RIPPLES, RIPPLES)))

    def error(self, x: Array, z: Array) -> tuple[Array, Array]:
        """Return the errors (dx, dz) [m] of the point that is read, at true points (x, z) (...) [m]."""
        edge_x = self.scanner.range_far * np.sin(self.scanner.fan)
        grid_x, grid_z = np.meshgrid(
            np.linspace(-edge_x, edge_x, GRID),
            np.linspace(self.scanner.range_near, self.scanner.range_far, GRID),
        )
        inside = np.abs(grid_x) <= grid_z * np.tan(self.scanner.fan)
        fx, fz = grid_x[inside], grid_z[inside]
        linear = np.column_stack([np.ones_like(fx), fx, fz])
        raw = self._raw(fx, fz)
        corrections = [np.linalg.lstsq(linear, part, rcond=None)[0] for part in raw]
        largest = float(np.quantile(np.abs(raw[1] - linear @ corrections[1]), MOST))
        here = np.stack([np.ones_like(x), x, z], -1)
        dx, dz = (
            (part - here @ correction) * self.size / largest
            for part, correction in zip(self._raw(x, z), corrections, strict=True)
        )
        return dx, dz

    def _raw(self, x: Array, z: Array) -> tuple[Array, Array]:
        """Return (dx, dz) [m], before they are scaled to ``size``, from a picture that is displaced by a small share of the drawn distortion."""
        u, v = self._picture(x, z)
        corner = self._picture(np.array([self.scanner.range_near * np.tan(self.scanner.fan)] * 2), np.array(
            [self.scanner.range_near, self.scanner.range_far]
        ))  # fmt: skip
        half_u, half_v = np.abs(corner[0]).max(), np.abs(corner[1]).max()
        a, b = u / half_u, v / half_v
        r2 = a**2 + b**2
        k1, k2, p1, p2 = self.lens
        swell = k1 * r2 + k2 * r2**2
        du = a * swell + 2 * p1 * a * b + p2 * (r2 + 2 * a**2)
        dv = b * swell + p1 * (r2 + 2 * b**2) + 2 * p2 * a * b
        for i in range(RIPPLES):
            for j in range(RIPPLES):
                wave = np.cos(np.pi / 2 * (i + 1) * (a + 1)) * np.cos(np.pi / 2 * (j + 1) * (b + 1))
                du, dv = du + self.ripples[0, i, j] * wave, dv + self.ripples[1, i, j] * wave
        small = 1e-6
        x_read, z_read = self._point(u + small * du * half_u, v + small * dv * half_v)
        return (x_read - x) / small, (z_read - z) / small

    def _axes(self) -> tuple[Array, Array]:
        """Return the camera's place (3,) [m] and axes (3, 3), rows right, down the picture and ahead."""
        middle = (self.scanner.range_near + self.scanner.range_far) / 2
        place = np.array([0.0, BASELINE, -BEHIND])
        ahead = np.array([0.0, 0.0, middle]) - place
        ahead = ahead / np.linalg.norm(ahead)
        right = np.array([1.0, 0.0, 0.0])
        return place, np.stack([right, np.cross(ahead, right), ahead])

    def _picture(self, x: Array, z: Array) -> tuple[Array, Array]:
        place, axes = self._axes()
        X, Y, Z = np.moveaxis((np.stack([x, np.zeros_like(x), z], -1) - place) @ axes.T, -1, 0)
        return X / Z, Y / Z

    def _point(self, u: Array, v: Array) -> tuple[Array, Array]:
        """Return the points (x, z) [m] of the laser's plane that the camera sees at (u, v)."""
        place, axes = self._axes()
        ray = np.stack([u, v, np.ones_like(u)], -1) @ axes
        along = -place[1] / ray[..., 1]
        return place[0] + along * ray[..., 0], place[2] + along * ray[..., 2]
