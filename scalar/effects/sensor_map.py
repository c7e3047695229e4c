"""A smooth error of a scanner over its profile that remains after its maker's calibration."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np
from numpy.polynomial import legendre

from scalar.data.poses import Poses
from scalar.effects.effect import Effect, Table
from scalar.effects.picture import Axis, Map, Profile, View
from scalar.effects.range_error import LEAST_INCIDENCE, RangeError
from scalar.geometry.se3 import Array
from scalar.sensors import kind_of
from scalar.sensors.scan_pieces import PIECES

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset

DEGREE = 4  # largest total degree of the polynomials in x and z: about two waves across the profile
TERMS = tuple((i, j) for i in range(DEGREE + 1) for j in range(DEGREE + 1 - i) if i + j)
_POWERS = ((0, 0), *TERMS)
_FLAT = ((0, 0), (1, 0), (0, 1))  # degrees of a plane's constant and slopes
FIRST_DEGREE_SHARE = 0.1  # prior std of slopes over the natural size: makers calibrate slopes; lengths of the arm are confounded with them
_AT_ONCE = 50_000  # points whose terms are computed together
_LEAST_HALF = 1e-4  # m: a profile of less than this half width counts as a point


@dataclass(frozen=True, eq=False)
class SensorMap(RangeError):
    """The measured range needs a smooth correction over the profile: products of Legendre polynomials in x and z.

    The constant is left out, since it is the zero of the range (``range_offset``). Every coefficient has a prior of the size of the errors that
    makers state, narrower for terms of higher degree. It is narrowest for the terms of first degree, which are almost confounded with the arm's
    lengths and the scanner's place.

    Each term of higher degree is a polynomial less its least-squares plane ``a + b x + c z`` over the measured points, so that it has no offset and
    no slope where the points lie. A polynomial alone has them, since points do not fill a rectangle evenly. The narrow prior of the slopes would
    then turn the waves of a scanner into errors of the arm's lengths: in 27 simulated workcells with a crooked scanner the map without this made
    positions up to four times worse, and no better in the mean.

    Attributes:
        middle: x and z [m] of the middle of the measured part of the profile.
        half: Half the width of that part in x and in z [m].
        planes: ``(len(TERMS), 3)``, the planes that are taken off the terms: constant, and slopes over x and z in units of ``half``.
    """

    middle: tuple[float, float] = (0.0, 0.0)
    half: tuple[float, float] = (1.0, 1.0)
    planes: tuple[tuple[float, ...], ...] = ((0.0, 0.0, 0.0),) * len(TERMS)

    name: ClassVar[str] = "sensor_map"
    kind: ClassVar[str] = "error of the scanner over its profile"
    sentence: ClassVar[str] = "the scanner's error varies smoothly over its profile"
    any_smooth_form: ClassVar[bool] = True
    natural: ClassVar[Mapping[str, float]] = {"m": 3e-5}
    natural_source: ClassVar[str] = (
        "line scanners are sold with a linearity of 0.02 to 0.1 % of a range of 0.1 m and more (data sheets of Keyence's LJ-V7000 and "
        "Micro-Epsilon's scanCONTROL): 0.03 mm, spread over a few terms"
    )
    basis_names: ClassVar[tuple[str, ...]] = tuple(f"u{axis}:{i}{j}" for axis in "xz" for i, j in _POWERS)

    @property
    def coefficient_names(self) -> list[str]:
        """The degrees in x and z."""
        return [f"x{i}_z{j}_m" for i, j in TERMS]

    @property
    def coefficient_units(self) -> list[str]:
        """Metres."""
        return ["m"] * len(TERMS)

    @property
    def prior_std(self) -> Array:
        """Return the natural size over the degree of each term, and a tenth of it for the terms of first degree."""
        return np.array(
            [self.natural["m"] * (FIRST_DEGREE_SHARE if i + j == 1 else 1 / (i + j)) for i, j in TERMS]
        )

    def contact_columns(
        self, poses: Poses, T_base_sensor: Array, planes: Any, plane_index: Array, contact: Array
    ) -> Array:
        """Return the normal along the sensor's x and z axes, for each product of powers."""
        powers = _in_powers(self.middle, self.half, self.planes)
        return (contact[:, 1:, None, None] * powers).reshape(len(contact), -1, powers.shape[1])

    def terms_at(self, x: Array, z: Array) -> Array:
        """Return every term ``(G, k)`` at points of the profile ``(G,)`` [m]."""
        u, v = ((w - m) / h for w, m, h in zip((x, z), self.middle, self.half, strict=True))
        return _polynomials(u, v) - np.column_stack([np.ones_like(u), u, v]) @ np.array(self.planes).T

    def to_mapping(self) -> dict[str, Any]:
        """Return middle and half width of the part of the profile that the map covers, and the planes that are taken off its terms."""
        return {
            "middle_m": list(self.middle),
            "half_m": list(self.half),
            "planes": [list(plane) for plane in self.planes],
        }

    @classmethod
    def from_mapping(cls, mapping: Mapping[str, Any]) -> Self:
        """Return the effect of ``to_mapping``; in files of older versions no planes are taken off."""
        middle, half = (tuple(float(v) for v in mapping[key]) for key in ("middle_m", "half_m"))
        planes = tuple(tuple(float(v) for v in plane) for plane in mapping.get("planes", cls.planes))
        return cls(middle, half, planes)  # type: ignore[arg-type]

    @classmethod
    def parsed(cls, dataset: Dataset, words: Sequence[str]) -> list[Effect]:
        """Return a map of the part of the profile that was measured.

        Raises:
            ValueError: The sensor measures no profile.
        """
        if not kind_of(dataset).scans:
            raise ValueError(f"this effect needs a scanner of profiles, and a {dataset.sensor.kind} is none")
        low, high = dataset.points.min(axis=0), dataset.points.max(axis=0)
        middle, half = (low + high) / 2, np.maximum((high - low) / 2, _LEAST_HALF)
        planes = _least_squares_planes((dataset.points - middle) / half)
        return [cls(tuple(middle.tolist()), tuple(half.tolist()), tuple(map(tuple, planes.tolist())))]

    @classmethod
    def candidates(cls, dataset: Dataset) -> list[Effect]:
        """Return the map, where the sensor scans profiles."""
        return list(cls.parsed(dataset, ())) if kind_of(dataset).scans else []

    def merged_with(self, other: Effect) -> Effect | None:
        """Return the map itself if the other is a map too: a second one would only double the variance that its prior allows."""
        return self if self.same_place(other) else None

    @property
    def advice(self) -> list[str]:
        """Return how to check the scanner."""
        return [
            "Check the linearity of the scanner over its whole profile on a flat surface, or have its maker calibrate it: the arm is not at fault."
        ]

    @property
    def clause(self) -> str:
        """Return what varies."""
        return "the error of the scanner varies smoothly over its profile"

    def table(self, std: Sequence[float | None]) -> Table | None:
        """Return None: single coefficients mean nothing to a reader; the picture shows the map."""
        return None

    def pictures(self, view: View) -> list[Profile | Map]:
        """Return the correction of the range over the profile."""
        found = view.pieces(self)
        steep = np.abs(found.incidence) > LEAST_INCIDENCE
        incidence = found.incidence[steep]
        rest, fitted = -found.height[steep] / incidence, found.of_effect[steep] / incidence
        x_axis, z_axis = Axis("x of the profile", "m"), Axis("z of the profile", "m")
        y_axis = Axis("correction of the range", "m")
        x, z = found.profile[steep].T
        note = f"Each scan is cut in {PIECES} pieces."
        return [Map(x_axis, z_axis, y_axis, x, z, fitted + rest, rest, found.pose[steep], note)]


def _polynomials(u: Array, v: Array) -> Array:
    """Return the products of Legendre polynomials of every term ``(G, k)`` at points of the profile in units of its half widths ``(G,)``."""
    of_u, of_v = legendre.legvander(u, DEGREE), legendre.legvander(v, DEGREE)
    return np.column_stack([of_u[:, i] * of_v[:, j] for i, j in TERMS])


def _least_squares_planes(points: Array) -> Array:
    """Return the least-squares plane ``(k, 3)`` of every term over points ``(P, 2)`` in units of the half widths; zero for terms of first degree."""
    gram, products = np.zeros((3, 3)), np.zeros((3, len(TERMS)))
    for u, v in (block.T for block in np.array_split(points, 1 + len(points) // _AT_ONCE)):
        straight = np.column_stack([np.ones_like(u), u, v])
        gram += straight.T @ straight
        products += straight.T @ _polynomials(u, v)
    planes = np.linalg.lstsq(gram, products, rcond=1e-12)[0].T
    planes[[i + j == 1 for i, j in TERMS]] = 0.0
    return planes


@lru_cache(maxsize=64)
def _in_powers(
    middle: tuple[float, float], half: tuple[float, float], planes: tuple[tuple[float, ...], ...]
) -> Array:
    """Return the coefficients ``(len(_POWERS), k)`` of every term of a map over products of powers of x and z; read-only."""
    of_x, of_z = (_in_powers_of(m, h) for m, h in zip(middle, half, strict=True))
    polynomials = np.array([[of_x[i, a] * of_z[j, b] for i, j in _POWERS] for a, b in _POWERS])
    flat = [_POWERS.index(power) for power in _FLAT]
    found = polynomials[:, 1:] - polynomials[:, flat] @ np.array(planes).T
    found.setflags(write=False)
    return found


@lru_cache(maxsize=64)
def _in_powers_of(middle: float, half: float) -> Array:
    """Return the Legendre polynomials of ``(v - middle) / half`` as coefficients of the powers of v, a row a polynomial; read-only."""
    shifted = np.polynomial.Polynomial([-middle / half, 1.0 / half])
    rows = np.zeros((DEGREE + 1, DEGREE + 1))
    for k in range(DEGREE + 1):
        row = legendre.leg2poly(np.eye(DEGREE + 1)[k])
        coefficients = np.polynomial.Polynomial(row)(shifted).coef
        rows[k, : len(coefficients)] = coefficients
    rows.setflags(write=False)
    return rows
