"""ROS 1 and ROS 2 recordings of a simulated campaign, written by the library's own writers."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from click.testing import CliRunner
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_typestore

from scalar.cli import cli
from scalar.data.dataset import Dataset

ORDER = "joint_1,joint_2,joint_3,joint_4,joint_5,joint_6"
JOINTS, SCANS = "/arm/joint_states", "/scanner/profile"
START = 1_700_000_000.0  # s
MOVE, STOP = 1.0, 1.2  # s
JOINT_RATE, SCAN_RATE = 50.0, 10.0  # Hz
LATE = 0.08  # s between the stamp of a message and its reception
DITHER = 1e-5  # rad, of the encoders
RAYS = 4000


def run(*arguments: object) -> tuple[int, str]:
    """Return status and output of the command line."""
    result = CliRunner().invoke(cli, [str(a) for a in arguments])
    return result.exit_code, result.output


def names(n: int) -> list[str]:
    """Return the joints' names in the order of publication, which is not the robot's, with one of a gripper."""
    return [f"joint_{i + 1}" for i in (2, 1, 0, *range(3, n))] + ["finger"]


def with_clutter(points: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Return a scan with a box beside the target, 9 points that are 30 mm nearer, and some stray echoes."""
    at = points[:, 0].max()
    box = np.column_stack([at + np.linspace(0.004, 0.012, 9), np.full(9, points[:, 1].min() - 0.03)])
    stray = points[rng.integers(len(points), size=4)] * [1.0, 0.8]
    both = np.concatenate([points, box, stray])
    return both[np.argsort(np.arctan2(both[:, 0], both[:, 1]))]


def messages(
    dataset: Dataset, store: Any, kind: str, *, moving: bool = False, blind: int = 0, named: bool = True
) -> Iterator[tuple[str, float, Any]]:
    """Yield topic, stamp and message of a campaign of moves and stops.

    Scans are published all the time, except during ``blind`` of every ``blind + 1`` stops. If ``moving``, the arm never stops.
    """
    rng = np.random.default_rng(1)
    q = dataset.q
    order = [int(name[6:]) - 1 for name in names(q.shape[1])[:-1]]
    before = q[0] + 0.1
    for k in range(dataset.n_poses):
        t0 = START + k * (MOVE + STOP)
        for t in np.arange(0.0, MOVE + STOP, 1 / JOINT_RATE):
            share = min(t / MOVE, 1.0) if not moving else t / (MOVE + STOP)
            now = before + share * (q[k] - before) + DITHER * rng.uniform(-1, 1, q.shape[1])
            yield JOINTS, t0 + t, joint_state(store, t0 + t, [*now[order], 0.02], named)
        scan = with_clutter(dataset.points[dataset.starts[k] : dataset.starts[k + 1]], rng)
        for t in np.arange(0.05, MOVE + STOP, 1 / SCAN_RATE):
            if t > MOVE and k % (blind + 1):
                continue
            shown = scan if t > MOVE else scan * [1.0, 0.7]
            yield (
                SCANS,
                t0 + t,
                laser_scan(store, t0 + t, shown) if kind == "LaserScan" else cloud(store, t0 + t, shown),
            )
        before = q[k]


def header(store: Any, stamp: float) -> Any:
    """Return a header; in ROS 1 it also has the number of the message."""
    time = store.types["builtin_interfaces/msg/Time"](
        sec=int(stamp), nanosec=round((stamp % 1) * 1e9) % 10**9
    )
    kind = store.types["std_msgs/msg/Header"]
    more = {"seq": 0} if "seq" in kind.__dataclass_fields__ else {}
    return kind(stamp=time, frame_id="frame", **more)


def joint_state(store: Any, stamp: float, position: list[float], named: bool = True) -> Any:
    """Return a message with positions, without velocities and efforts; with names unless ``named`` is False."""
    kind, none = store.types["sensor_msgs/msg/JointState"], np.zeros(0)
    return kind(
        header=header(store, stamp),
        name=names(len(position) - 1) if named else [],
        position=np.array(position),
        velocity=none,
        effort=none,
    )


def laser_scan(store: Any, stamp: float, points: np.ndarray) -> Any:
    """Return a scan over evenly spaced rays, x of ROS along the sensor's z; ranges without an echo are infinite."""
    angles = np.arctan2(points[:, 0], points[:, 1])
    first, step = float(angles.min()), float(np.ptp(angles)) / (RAYS - 1)
    ranges = np.full(RAYS, np.inf, dtype=np.float32)
    ranges[np.round((angles - first) / step).astype(int)] = np.linalg.norm(points, axis=1)
    return store.types["sensor_msgs/msg/LaserScan"](
        header=header(store, stamp), angle_min=first, angle_max=float(angles.max()), angle_increment=step, time_increment=0.0,
        scan_time=0.1, range_min=0.01, range_max=10.0, ranges=ranges, intensities=np.zeros(0, dtype=np.float32),
    )  # fmt: skip


def cloud(store: Any, stamp: float, points: np.ndarray) -> Any:
    """Return a cloud with x, y = 0 and z of SCALAR's sensor frame, and an intensity; lost points are NaN."""
    field = store.types["sensor_msgs/msg/PointField"]
    fields = [
        field(name=name, offset=4 * i, datatype=7, count=1)
        for i, name in enumerate(("x", "y", "z", "intensity"))
    ]
    rows = np.zeros((len(points) + 3, 4), dtype="<f4")
    rows[:-3, 0], rows[:-3, 2], rows[-3:, :3] = points[:, 0], points[:, 1], np.nan
    return store.types["sensor_msgs/msg/PointCloud2"](
        header=header(store, stamp), height=1, width=len(rows), fields=fields, is_bigendian=False, point_step=16,
        row_step=16 * len(rows), data=np.frombuffer(rows.tobytes(), dtype=np.uint8), is_dense=False,
    )  # fmt: skip


def write_bag(
    dataset: Dataset,
    path: Path,
    version: int | str,
    kind: str,
    *,
    moving: bool = False,
    blind: int = 0,
    named: bool = True,
) -> Path:
    """Write the campaign as a bag of ROS 1, ROS 2 (MCAP) or ``db3`` (ROS 2, SQLite); a third topic holds neither joints nor scans."""
    store = get_typestore(Stores.ROS1_NOETIC if version == 1 else Stores.ROS2_HUMBLE)
    types = {
        JOINTS: "sensor_msgs/msg/JointState",
        SCANS: f"sensor_msgs/msg/{kind}",
        "/note": "std_msgs/msg/String",
    }
    writer: Any = (
        Writer1(path)
        if version == 1
        else Writer2(
            path, version=9, storage_plugin=StoragePlugin.SQLITE3 if version == "db3" else StoragePlugin.MCAP
        )
    )
    with writer:
        connections = {
            topic: writer.add_connection(topic, name, typestore=store) for topic, name in types.items()
        }
        for topic, stamp, message in sorted(
            messages(dataset, store, kind, moving=moving, blind=blind, named=named),
            key=lambda entry: entry[1],
        ):
            name = types[topic]
            raw = store.serialize_ros1(message, name) if version == 1 else store.serialize_cdr(message, name)
            writer.write(connections[topic], round((stamp + LATE) * 1e9), raw)
    return path
