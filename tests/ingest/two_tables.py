"""A table of joint angles and a table of measured points, for tests of the import."""

from datetime import UTC, datetime, timedelta

import numpy as np

from tests.ingest.foreign_tables import N, joints, write_table
from tests.small_datasets import description

START = datetime(2026, 11, 26, 8, 4, 30, tzinfo=UTC)
SECONDS = [30 * k + 1 for k in range(N)]
XYZ = {name: {"column": name, "unit": "mm"} for name in "xyz"}


def angles():
    """Return ``(N, 6)``: the joint angles of the poses [rad]."""
    return np.round(np.random.default_rng(8).uniform(-2, 2, (N, 6)), 4)


def places():
    """Return ``(N, 3)``: the measured positions [mm]."""
    return np.round(np.random.default_rng(9).uniform(500, 3000, (N, 3)), 3)


def two_tables(folder, first_of_points=1, points=None, first_of_poses=1, stamps=None):
    """Write robot.csv and tracker.csv, and return their mapping; rows of the tracker may be given."""
    texts = [[str(k + first_of_poses), *map(str, row)] for k, row in enumerate(angles())]
    names = ["Nr", *(f"J{i}" for i in range(1, 7))]
    if stamps is not None:
        texts, names = [[*row, stamp] for row, stamp in zip(texts, stamps, strict=True)], [*names, "Clock"]
    write_table(folder / "robot.csv", texts, names, ",")
    if points is None:
        points = [[f"{k + first_of_points}", *map(str, row)] for k, row in enumerate(places())]
    write_table(folder / "tracker.csv", points, ["Nr", "x", "y", "z"], ",")
    return {
        "format": "scalar-mapping/1",
        "poses": {"files": [{"name": "robot.csv"}], "columns": {"pose": {"column": "Nr"}, **joints()}},
        "points": {"files": [{"name": "tracker.csv"}], "columns": {"pose": {"column": "Nr"}, **XYZ}},
        "dataset": description("tracker"),
    }


def by_time(folder, *, local=3600, add=0.0, within=5.0, late=2.0):
    """Write tables that only their times join: the robot's in local time, the tracker's in UTC with three more points, the fifth pose unmeasured."""
    robot = [
        f"{START + timedelta(seconds=second + local):%Y-%m-%dT%H:%M:%S}+01:00"
        if local
        else f"{START + timedelta(seconds=second):%d.%m.%Y %H:%M:%S}"
        for second in SECONDS
    ]
    rows = [
        [f"{START + timedelta(seconds=SECONDS[k] + late):%Y-%m-%dT%H:%M:%S}Z", *map(str, places()[k])]
        for k in range(N)
        if k != 4
    ]
    rows += [
        [f"{START + timedelta(seconds=second):%Y-%m-%dT%H:%M:%S}Z", "9", "9", "9"]
        for second in (15, 45, 9999)
    ]
    mapping = two_tables(folder, points=rows, stamps=robot)
    mapping["poses"]["columns"]["time"] = {"column": "Clock"}
    del mapping["points"]["columns"]["pose"]
    mapping["points"] |= {
        "nearest_time": {"column": "Nr", "within": within, "add": add},
        "matched_only": True,
    }
    return mapping
