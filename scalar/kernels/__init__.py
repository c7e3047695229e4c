"""The inner loops compiled from ``kernels.c``, if a C compiler was there at set-up. Without them NumPy computes the same, several times slower.

``hatch_build.py`` builds ``kernels.so`` next to this file. A library that was built from other sources than those in this folder is not
used. ``SCALAR_KERNELS=off`` in the environment switches to NumPy.
"""

from __future__ import annotations

import ctypes
import os
import zlib
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_FOLDER = Path(__file__).parent
_address_of, _from_buffer = ctypes.addressof, ctypes.c_char.from_buffer
_int, _at, _float = ctypes.c_int64, ctypes.c_void_p, ctypes.c_double


class ProblemStruct(ctypes.Structure):
    """``Problem`` of ``plane_model.h``: a model of arm, sensor and planes."""

    _fields_ = (
        *((name, _int) for name in ("N", "n", "K", "m")),
        *((name, _at) for name in ("turned", "index", "factors", "T_base_0", "T_n_flange")),
        *((name, _at) for name in ("R_sensor", "normals", "tangents")),
    )


class PublishedStruct(ctypes.Structure):
    """``Published`` of ``published_model.h``: the original paper's model of arm, sensor and planes."""

    _fields_ = (
        *((name, _int) for name in ("N", "n", "K", "reading")),
        *((name, _at) for name in ("q", "index", "factors", "beta", "T_base_0", "T_n_flange")),
    )


class StartStruct(ctypes.Structure):
    """``Start`` of ``linear_start.h``: scans of planes from which a scanner's pose is guessed."""

    _fields_ = (
        *((name, _int) for name in ("N", "K", "m")),
        *((name, _at) for name in ("R", "R_metric", "T_base_flange", "index", "use", "normals", "distances")),
    )


class FreeStruct(ctypes.Structure):
    """``Free`` of ``normal_equations.h``: which coordinates are free, with their priors."""

    _fields_ = (("F", _int), *((name, _at) for name in ("free", "mean", "weight")))


_ARGUMENTS = {
    "frames": (_int, _int, _at, _at, ctypes.c_int, _at, _at),
    "screws": (_int, _int, _at, _at, ctypes.c_int, _int, _at),
    "compress": (_int, _at, _at, _at, ctypes.c_int, _float, _at),
    "factors": (_int, _int, _at, _at, _at),
    "profiles": (_int, _at, _at, _at, ctypes.c_int, _float, _int, _at, _at),
    "published": (ctypes.POINTER(PublishedStruct), _at, _at, _at, _at),
    "linear_start": (ctypes.POINTER(StartStruct), _int, _at, _at),
    "linearise": (ctypes.POINTER(ProblemStruct), _at, _at, _at),
    "fit": (
        ctypes.POINTER(ProblemStruct), ctypes.POINTER(FreeStruct), _float, _float, _int, _at,
        ctypes.POINTER(_float), ctypes.POINTER(_int),
    ),
    "turned": (_int, _at, _at),
    "ends": (_int, _int, _at, _at, _at, _at, _at),
    "contacts": (_int, _at, _at, _at, _at, _at),
    "tangents": (_int, _at, _at),
    "scatter": (_int, _int, _int, _at, _at, _at, _at),
    "off_lines": (_int, _at, _at, _at),
    "normals": (ctypes.POINTER(ProblemStruct), ctypes.POINTER(FreeStruct), _at, _at, _at, ctypes.POINTER(_float)),
    "shrunk_gains": (_int, _int, _at, _at, _at, _at, _at),
    "select_forward": (_int, _int, _at, _at, _float, _at, _at),
    "restricted_likelihood": (_int, _int, _at, _at, _float, ctypes.POINTER(_float), _at),
    "best_extensions": (_int, _int, _int, _int, _at, _at, _at, _float, _at, _at, _at),
    "set_gains": (_int, _at, _at, _int, _int, _at, _at, _at),
    "extension_gains": (_int, _at, _at, _int, _at, _at, _int, _at, _at, _at, _at),
}  # fmt: skip


def checksum(folder: Path = _FOLDER) -> int:
    """Return a checksum of the C sources in a folder; ``hatch_build.py`` compiles it into the library."""
    found = 0
    for path in sorted([*folder.glob("*.h"), *folder.glob("*.c")]):
        found = zlib.crc32(path.read_bytes(), found)
    return found


def load(library: Path = _FOLDER / "kernels.so", source: Path = _FOLDER) -> ctypes.CDLL | None:
    """Return a library; None if there is none, if it was built from other sources than those in a folder, or if ``SCALAR_KERNELS`` is ``off``."""
    if os.environ.get("SCALAR_KERNELS") == "off":
        return None
    try:
        found = ctypes.CDLL(str(library))
        found.source_checksum.restype = ctypes.c_uint32
        if found.source_checksum() != checksum(source):
            return None
        for name, arguments in _ARGUMENTS.items():
            getattr(found, name).argtypes = arguments
        found.select_forward.restype = ctypes.c_int64
    except (OSError, AttributeError):
        return None
    return found


LIBRARY = load()

NOT_POSITIVE, NO_MEMORY = -1, -2
"""What functions of the library return where a matrix has lost so many digits that it is not positive definite, and without memory."""


def contiguous(values: NDArray[np.generic]) -> Array:
    """Return an array as the library reads it: float64, row by row."""
    return np.ascontiguousarray(values, dtype=np.float64)


def address(array: NDArray[Any]) -> int:
    """Return where the numbers of an array begin in memory, in a quarter of the time of ``array.ctypes.data``, as a calibration asks often."""
    try:
        return _address_of(_from_buffer(array))  # pyright: ignore[reportArgumentType]
    except (TypeError, ValueError):  # an array that is empty, read-only or not contiguous
        return array.ctypes.data


def checked(status: int) -> None:
    """Check the status that a function of the library returned.

    Raises:
        MemoryError: The function could not allocate memory.
    """
    if status < 0:
        raise MemoryError


def frames(q: Array, geometry: Array, T_base_0: Array) -> Array | None:
    """Return ``T_base_i`` of every joint's frame ``(N, n + 1, 4, 4)``, or None without the library.

    Args:
        q: ``(N, n)`` [rad].
        geometry: ``(5, n)``, rows a [m], alpha [rad], d [m], theta [rad], beta [rad]; ``(N, 5, n)`` if it differs from pose to pose.
        T_base_0: ``(4, 4)``.
    """
    if LIBRARY is None:
        return None
    N, n = q.shape
    q, geometry, T_base_0 = contiguous(q), contiguous(geometry), contiguous(T_base_0)
    found = np.empty((N, n + 1, 4, 4))
    angles, links, base = (address(each) for each in (q, geometry, T_base_0))
    checked(LIBRARY.frames(N, n, angles, links, geometry.ndim == 3, base, address(found)))
    return found


def screws(frames: Array, geometry: Array, out: Array) -> bool:
    """Write the screw of every geometric parameter into an array, as ``Robot.screws`` defines them; return False without the library.

    Args:
        frames: ``(N, n + 1, 4, 4)``.
        geometry: ``(5, n)`` or ``(N, 5, n)``, as for ``frames``.
        out: ``(N, 6, P)``, contiguous; the first 5 n columns are written.
    """
    if LIBRARY is None:
        return False
    frames, geometry = contiguous(frames), contiguous(geometry)
    N, n = len(frames), geometry.shape[-1]
    assert out.flags.c_contiguous and out.shape[2] >= 5 * n
    LIBRARY.screws(N, n, address(frames), address(geometry), geometry.ndim == 3, out.shape[2], address(out))
    return True


def compress(
    points: Array,
    starts: NDArray[np.int64],
    contact: Array | None = None,
    *,
    along_z: bool = False,
    sigma: float = 1.0,
) -> Array | None:
    """Return the triangular factors ``(N, 3, 3)`` of the weighted points ``w [1, x, z]`` of N scans; None without the library.

    Args:
        points: ``(P, 2)`` [m], x and z of the points of all scans.
        starts: ``(N + 1,)``, index of the first point of each scan, and P.
        contact: ``(N, 3)``, the contact vector of each scan, ``(n.o - d, n.X, n.Z)`` with its plane's normal n and distance d, and the sensor's
            origin o and axes X and Z; None for weights of 1. Else ``w = 1 / (sigma |n . e|)``, e the direction in which a point errs.
        along_z: Whether points err along z instead of along their rays.
        sigma: Standard deviation of a point along e [m].
    """
    if LIBRARY is None:
        return None
    points = contiguous(points)
    starts = np.ascontiguousarray(starts, dtype=np.int64)
    place = None if contact is None else contiguous(contact)
    N = len(starts) - 1
    found = np.empty((N, 3, 3))
    at = None if place is None else address(place)
    checked(LIBRARY.compress(N, address(points), address(starts), at, along_z, sigma, address(found)))
    return found


def factors(basis: Array, starts: NDArray[np.int64]) -> Array | None:
    """Return the triangular factors ``(N, k, k)`` of k functions of the points of N scans, or None without the library.

    Args:
        basis: ``(P, k)``, the functions at the points of all scans.
        starts: ``(N + 1,)``, as for ``compress``.
    """
    if LIBRARY is None:
        return None
    basis, starts = contiguous(basis), np.ascontiguousarray(starts, dtype=np.int64)
    N, k = len(starts) - 1, basis.shape[1]
    found = np.empty((N, k, k))
    checked(LIBRARY.factors(N, k, address(basis), address(starts), address(found)))
    return found


def profiles(
    points: Array,
    starts: NDArray[np.int64],
    contact: Array,
    codes: NDArray[np.int64],
    *,
    along_z: bool,
    sigma: float,
) -> Array | None:
    """Return the weighted components ``(N, 3, k)`` of k functions of the points of each scan along 1, t and t^2; None without the library.

    Args:
        points: ``(P, 2)`` [m], x and z of the points of all scans.
        starts: ``(N + 1,)``, as for ``compress``; no scan is empty.
        contact: ``(N, 3)``, as for ``compress``, whose weights are used; 1, t and t^2 are
            orthonormalised, t being the coordinate along the line in which the plane cuts the scan.
        codes: ``(k, 4)``, (along, r, i, j) of the functions ``u reach^r x^i z^j``. u is 1 where ``along`` is 0, and the x or z component
            of the direction in which a point errs where it is 1 or 2.
        along_z: Whether points err along z instead of along their rays; the reach is then z instead of the ray's length.
        sigma: Standard deviation of a point along that direction [m].
    """
    if LIBRARY is None:
        return None
    points, contact = contiguous(points), contiguous(contact)
    starts, codes = (np.ascontiguousarray(numbers, dtype=np.int64) for numbers in (starts, codes))
    N, k = len(starts) - 1, len(codes)
    found = np.empty((N, 3, k))
    where = (address(array) for array in (points, starts, contact))
    checked(LIBRARY.profiles(N, *where, along_z, sigma, k, address(codes), address(found)))
    return found
