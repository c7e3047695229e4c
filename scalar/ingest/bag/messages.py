"""Read joint states and scans from a recorded ROS 1 or ROS 2 bag, without ROS.

The points of a scan are expressed in the xz plane of SCALAR's sensor frame, whose z points away from the scanner. For a ``LaserScan``, the
ray at angle zero, x in ROS, becomes z, and y becomes x (a cyclic exchange, so that the frame stays right-handed). For a ``PointCloud2``, the
coordinate that is the same in all points says which frame it is in: y for SCALAR's own frame, z for that of a ``LaserScan``.
"""

# pyright: reportMissingTypeStubs=false, reportMissingImports=false, reportUnknownMemberType=false

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from scalar.data.io.regular_file import check_regular_file
from scalar.data.located_table import did_you_mean, shorten
from scalar.errors import Fault, InvalidInput
from scalar.geometry.se3 import Array

LIBRARY = "rosbags"
JOINTS = ("sensor_msgs/msg/JointState",)
SCANS = ("sensor_msgs/msg/LaserScan", "sensor_msgs/msg/PointCloud2")
MAX_BAG_BYTES = 50_000_000_000
"""Largest size of a file of a recording [bytes]; messages are read one by one."""
_NANO = 1e-9
_FLAT = 1e-6  # times the largest coordinate: one that varies by less counts as the same in all points
_NUMBERS = {7: "f4", 8: "f8"}  # datatypes of PointField that hold real numbers


@dataclass(frozen=True, eq=False)
class Recording:
    """What was recorded.

    Attributes:
        joint_names: Names of the n recorded joints, as in the messages; the robot may have fewer.
        joint_times: ``(J,)`` [s], ascending.
        positions: ``(J, n)`` [rad, m], in the order of the names.
        scan_times: ``(S,)`` [s], ascending, on the same clock.
        scans: S arrays ``(M, 2)`` [m], x and z in the sensor's frame; rays without an echo left out.
        joint_topic, scan_topic: Topics of the messages.
    """

    joint_names: tuple[str, ...]
    joint_times: Array
    positions: Array
    scan_times: Array
    scans: list[Array]
    joint_topic: str
    scan_topic: str


def read_bag(path: Path, joint_topic: str | None = None, scan_topic: str | None = None) -> Recording:
    """Return the joint states and the scans of a recording.

    Args:
        path: A ``.bag`` file (ROS 1), or a folder with metadata.yaml or a ``.mcap`` or ``.db3`` file (ROS 2).
        joint_topic: Topic of the ``JointState`` messages; None for the only topic of that type.
        scan_topic: Topic of the ``LaserScan`` or ``PointCloud2`` messages; None for the only topic of these types.

    Raises:
        InvalidInput: The recording cannot be read, lacks a topic, or has clouds that are not scans in a plane.
    """
    file = path.name
    if not path.exists():
        raise InvalidInput(
            Fault(file, "no such file or folder; give a .bag file, or the folder of a ROS 2 recording")
        )
    if not path.is_dir():
        check_regular_file(path, MAX_BAG_BYTES)
    try:
        from rosbags.highlevel import AnyReader
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        message = (
            f"needs the library {LIBRARY}, which is not installed; pip install 'scalar-calibration[bags]'"
        )
        raise InvalidInput(Fault("scalar import-bag", message)) from None
    try:
        with (
            _path_by_kind(path) as named,
            AnyReader([named], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as reader,
        ):
            return _read(reader, file, joint_topic, scan_topic)
    except InvalidInput:
        raise
    except Exception as error:  # whatever the library raises on a damaged file is a fault of that file
        words = " ".join(str(error).split()) or type(error).__name__
        message = (
            f"cannot be read as a ROS bag ({shorten(words, 120)[1:-1]}); was it recorded to its end and copied whole? "
            "'rosbag reindex' or 'ros2 bag reindex' may repair it"
        )
        raise InvalidInput(Fault(file, message)) from None


@contextmanager
def _path_by_kind(path: Path) -> Iterator[Path]:
    """Yield a path to a recording whose name shows its kind to the library, which would take a folder named ``*.bag`` for a file of ROS 1."""
    if not path.is_dir() or path.suffix != ".bag":
        yield path
        return
    with TemporaryDirectory() as folder:
        link = Path(folder) / path.stem.replace(".", "_")
        link.symlink_to(path.resolve(), target_is_directory=True)
        yield link


def _read(reader: Any, file: str, joint_topic: str | None, scan_topic: str | None) -> Recording:
    """Return the recording of an open file; ``joint_topic`` and ``scan_topic`` are those that were asked for, or None to find them."""
    joints = _topic(reader, file, joint_topic, JOINTS, "--joints")
    scans = _topic(reader, file, scan_topic, SCANS, "--scans")
    wanted = [connection for connection in reader.connections if connection.topic in (joints, scans)]
    names: tuple[str, ...] | None = None
    joint_rows: list[tuple[float, float, list[float]]] = []
    scan_rows: list[tuple[float, float, Array]] = []
    for connection, received, raw in reader.messages(connections=wanted):
        message = reader.deserialize(raw, connection.msgtype)
        stamp = message.header.stamp.sec + _NANO * message.header.stamp.nanosec
        if connection.topic == scans:
            scan_rows.append((stamp, _NANO * received, _points(message, connection.msgtype, file, scans)))
            continue
        # Some drivers publish positions without names: these are taken in their order.
        published = tuple(map(str, message.name)) or tuple(
            f"position {k + 1}" for k in range(len(message.position))
        )
        if names is None:
            names = published
        # Another publisher may publish other joints on the same topic; its messages are left out.
        if published == names and len(message.position) == len(names):
            joint_rows.append((stamp, _NANO * received, [float(x) for x in message.position]))
    for rows, topic in ((joint_rows, joints), (scan_rows, scans)):
        if not rows:
            raise InvalidInput(
                Fault(file, f"topic {topic} has no messages with data; record it, or name another")
            )
    joint_times, scan_times = _one_clock(joint_rows, scan_rows)
    first, second = np.argsort(joint_times, kind="stable"), np.argsort(scan_times, kind="stable")
    return Recording(
        names or (),
        joint_times[first],
        np.array([row[2] for row in joint_rows])[first],
        scan_times[second],
        [scan_rows[i][2] for i in second],
        joints,
        scans,
    )


def _topic(reader: Any, file: str, wanted: str | None, types: Sequence[str], option: str) -> str:
    """Return the topic to read: the one that is named, or the only one of these types."""
    kinds = " or ".join(kind.rpartition("/")[2] for kind in types)
    by_topic = {connection.topic: connection.msgtype for connection in reader.connections}
    of_type = [topic for topic, kind in by_topic.items() if kind in types]
    if wanted is None:
        if len(of_type) == 1:
            return of_type[0]
        what = "none" if not of_type else f"{len(of_type)} ({', '.join(of_type)})"
        there = "" if of_type else f"; the recording has {_listed(by_topic)}"
        raise InvalidInput(Fault(file, f"{what} of its topics is of {kinds}{there}; name one with {option}"))
    if wanted not in by_topic:
        hint = did_you_mean(wanted, list(by_topic))
        raise InvalidInput(
            Fault(
                file,
                f"no topic {shorten(wanted)}; {hint}the recording has {_listed(by_topic)}; correct {option}",
            )
        )
    if wanted not in of_type:
        raise InvalidInput(
            Fault(file, f"topic {wanted} is of {by_topic[wanted]}, and {kinds} is needed; correct {option}")
        )
    return wanted


def _listed(by_topic: dict[str, str]) -> str:
    """Return the topics of a recording with their types, eight at most."""
    shown = [f"{topic} ({kind.rpartition('/')[2]})" for topic, kind in list(by_topic.items())[:8]]
    return ", ".join(shown) + (f" and {len(by_topic) - 8} more" if len(by_topic) > 8 else "") or "no topics"


def _one_clock(
    joints: Sequence[tuple[float, float, Any]], scans: Sequence[tuple[float, float, Any]]
) -> tuple[Array, Array]:
    """Return the times [s] of joint states and scans: the stamps of their headers, or the times of reception if the stamps are not of one clock."""
    stamps = [np.array([row[0] for row in rows]) for rows in (joints, scans)]
    received = [np.array([row[1] for row in rows]) for rows in (joints, scans)]
    stamped = all(np.all(times > 0) for times in stamps)
    overlap = min(times.max() for times in stamps) > max(times.min() for times in stamps)
    one, two = stamps if stamped and overlap else received
    return one, two


def _points(message: Any, kind: str, file: str, topic: str) -> Array:
    """Return the points of a message in the sensor's frame ``(M, 2)`` [m]."""
    if kind == SCANS[0]:
        ranges = np.asarray(message.ranges, dtype=float)
        angles = message.angle_min + message.angle_increment * np.arange(len(ranges))
        seen = np.isfinite(ranges) & (ranges >= max(message.range_min, 1e-9)) & (ranges <= message.range_max)
        return np.column_stack([np.sin(angles), np.cos(angles)])[seen] * ranges[seen, None]
    xyz = _cloud(message, file, topic)
    flat = (
        np.ptp(xyz, axis=0) <= _FLAT * max(float(np.abs(xyz).max(initial=0.0)), 1e-9)
        if len(xyz)
        else np.ones(3, bool)
    )
    if flat[1]:
        return xyz[:, [0, 2]]
    if flat[2]:
        return xyz[:, [1, 0]]
    text = (
        f"the points on topic {topic} lie in no plane y = constant or z = constant of their frame; "
        "give the scanner's own profiles, not a merged cloud"
    )
    raise InvalidInput(Fault(file, text))


def _cloud(message: Any, file: str, topic: str) -> Array:
    """Return the finite points of a ``PointCloud2`` ``(M, 3)`` [m]."""
    fields = {field.name: field for field in message.fields}
    missing = [name for name in "xyz" if name not in fields or fields[name].datatype not in _NUMBERS]
    if missing:
        raise InvalidInput(
            Fault(file, f"the clouds on topic {topic} have no field {missing[0]} of real numbers")
        )
    order = ">" if message.is_bigendian else "<"
    layout = np.dtype(
        {
            "names": list("xyz"),
            "formats": [order + _NUMBERS[fields[name].datatype] for name in "xyz"],
            "offsets": [fields[name].offset for name in "xyz"],
            "itemsize": message.point_step,
        }
    )
    rows = np.asarray(message.data, dtype=np.uint8).reshape(message.height, message.row_step)
    data = np.ascontiguousarray(rows[:, : message.width * message.point_step]).tobytes()
    values = np.frombuffer(data, dtype=layout)
    xyz = np.column_stack([values[name].astype(float) for name in "xyz"])
    return xyz[np.all(np.isfinite(xyz), axis=1)]
