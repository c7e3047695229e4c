"""Points find the pose that they belong to: by its time, by numbers that another program counts, in the order of numbers in names of files."""

import numpy as np
import pandas as pd
import pytest

from tests.ingest.foreign_tables import N, imported, joints, refused, run, write_table
from tests.ingest.two_tables import XYZ, angles, by_time, places, two_tables
from tests.small_datasets import description


@pytest.mark.parametrize("local", [3600, 0])
def test_points_belong_to_the_pose_that_is_nearest_in_time(tmp_path, local):
    """Time zones are heeded; points between the poses, and the pose that was not measured, are left out and named."""
    mapping = by_time(tmp_path, local=local)
    said = run(tmp_path, mapping, tmp_path).output
    assert (
        "3 rows left out, not within 5 s of a pose" in said
        and "poses without points (matched_only): 6" in said
    )
    data = imported(tmp_path, mapping, tmp_path)
    np.testing.assert_array_equal(data.pose_ids, [1, 2, 3, 4, 6, 7, 8, 9])
    np.testing.assert_allclose(data.points, np.delete(places(), 4, axis=0) / 1000, rtol=1e-12)
    np.testing.assert_array_equal(data.q, np.delete(angles(), 4, axis=0))


@pytest.mark.parametrize(
    ("changed", "word"),
    [
        ({"within": 29.0}, "of two poses"),
        ({"add": 90_000.0}, "nearest_time.add"),
    ],
)
def test_times_that_leave_the_pose_open_are_refused(tmp_path, changed, word):
    """A point between two poses has none; clocks that never meet are probably of two time zones."""
    refused(tmp_path, run(tmp_path, by_time(tmp_path, **changed), tmp_path), "tracker.csv", word)


def test_dates_in_one_table_and_seconds_in_the_other_are_refused(tmp_path):
    """Nothing says when the seconds began."""
    mapping = by_time(tmp_path)
    mapping["points"]["nearest_time"]["column"] = "x"
    refused(tmp_path, run(tmp_path, mapping, tmp_path), "one table states the date")


@pytest.mark.parametrize("extra", [{}, {"matched_only": True}])
def test_poses_that_are_counted_from_another_number_are_never_joined_as_they_stand(tmp_path, extra):
    """1 to 9 and 0 to 8 overlap in all but two; the message says what to add, and with it the rows are joined rightly."""
    mapping = two_tables(tmp_path, first_of_poses=0)
    mapping["points"] |= extra
    refused(
        tmp_path,
        run(tmp_path, mapping, tmp_path),
        "numbered 1 to 9 here and 0 to 8 in robot.csv",
        "offset: -1",
    )
    mapping["points"]["columns"]["pose"]["offset"] = -1
    data = imported(tmp_path, mapping, tmp_path)
    np.testing.assert_allclose(data.points, places() / 1000, rtol=1e-12)


def test_a_pose_without_points_is_left_out_where_asked_and_refused_otherwise(tmp_path):
    """A beam that was lost costs its pose, and no row of the robot's log has to be removed by hand."""
    rows = [[f"P{k + 1}", *map(str, row)] for k, row in enumerate(places()) if k != 3]
    mapping = two_tables(tmp_path, points=[*rows, ["REF1", "1", "2", "3"]])
    refused(tmp_path, run(tmp_path, mapping, tmp_path), "'REF1'", "rows_like: {Nr: 'P[0-9]*'}")
    mapping["points"]["rows_like"] = {"Nr": "P[0-9]*"}
    refused(tmp_path, run(tmp_path, mapping, tmp_path), "pose 4 has no row in tracker.csv")
    mapping["points"]["matched_only"] = True
    result = run(tmp_path, mapping, tmp_path)
    assert "tracker.csv: 1 row left out, which do not have Nr like" in result.output
    assert "robot.csv: 1 row left out, poses without points (matched_only): 5" in result.output
    data = imported(tmp_path, mapping, tmp_path)
    np.testing.assert_allclose(data.points, np.delete(places(), 3, axis=0) / 1000, rtol=1e-12)


def test_a_measurement_at_the_origin_of_the_instrument_is_asked_about(tmp_path):
    """Trackers write zeros where they did not see the target; ``drop_zeros`` leaves these rows out."""
    rows = [[str(k + 1), *(map(str, row) if k != 2 else "000")] for k, row in enumerate(places())]
    mapping = two_tables(tmp_path, points=rows)
    refused(
        tmp_path, run(tmp_path, mapping, tmp_path), "tracker.csv, row 4", "exactly 0", "drop_zeros: [x, y, z]"
    )
    mapping["points"] |= {"drop_zeros": ["x", "y", "z"], "matched_only": True}
    assert len(imported(tmp_path, mapping, tmp_path).pose_ids) == N - 1
    mapping["points"]["columns"] |= {"x": {**XYZ["x"], "offset": 100}}
    assert len(imported(tmp_path, mapping, tmp_path).pose_ids) == N - 1, "the zeros are those of the file"


def test_a_socket_at_the_origin_of_its_plate_is_a_place_among_others(tmp_path):
    """A ball returns to three sockets, whose stated places are what was measured: rows of zeros are one of them."""
    sockets = ["000", ("50", "0", "0"), ("0", "50", "0")]
    rows = [[str(k + 1), *sockets[(k + 1) % 3]] for k in range(N)]
    data = imported(tmp_path, two_tables(tmp_path, points=rows), tmp_path)
    assert (data.points == 0.0).all(axis=1).sum() == N // 3


def test_positions_that_count_from_the_first_one_are_moved_by_an_offset(tmp_path):
    """Where the target did stand at the origin, an offset of one coordinate keeps it from being taken for one that was not seen."""
    moved = places() - places()[2]
    rows = [[str(k + 1), *map(str, row)] for k, row in enumerate(moved)]
    mapping = two_tables(tmp_path, points=rows)
    refused(tmp_path, run(tmp_path, mapping, tmp_path), "offset: 100")
    mapping["points"]["columns"] |= {"x": {**XYZ["x"], "offset": 100}}
    data = imported(tmp_path, mapping, tmp_path)
    np.testing.assert_allclose(data.points, (moved + np.array([100.0, 0.0, 0.0])) / 1000, rtol=0, atol=1e-15)


def test_files_are_taken_in_the_order_of_the_numbers_in_their_names(tmp_path):
    """Pose 10 was measured after pose 9, and not after pose 1."""
    for k in range(12):
        row = [*map(str, [*angles()[k % N], *places()[k % N]])]
        write_table(
            tmp_path / f"Pose {k + 1}.csv", [row], [*(f"J{i}" for i in range(1, 7)), "x", "y", "z"], ","
        )
    mapping = {
        "format": "scalar-mapping/1",
        "poses": {
            "files": [{"name": "Pose *.csv"}],
            "columns": {"pose": {"column": "@file_number"}, **joints(), **XYZ},
        },
        "dataset": description("tracker"),
    }
    data = imported(tmp_path, mapping, tmp_path)
    np.testing.assert_array_equal(data.pose_ids, np.arange(1, 13))
    files = sorted(tmp_path.glob("Pose *.csv"))
    np.testing.assert_array_equal(imported(tmp_path, mapping, *files).pose_ids, np.arange(1, 13))
    del mapping["poses"]["columns"]["pose"]
    np.testing.assert_array_equal(imported(tmp_path, mapping, tmp_path).q, angles()[np.arange(12) % N])


def test_dates_of_several_files_count_from_one_midnight(tmp_path):
    """The second day of a campaign comes a day after the first."""
    names = ["Clock", *(f"J{i}" for i in range(1, 7)), "x", "y", "z"]
    for day, part in ((26, slice(0, 4)), (27, slice(4, N))):
        rows = [
            [f"{day}.11.2026 9:00:0{k}", *map(str, [*q, *p])]
            for k, (q, p) in enumerate(zip(angles()[part], places()[part], strict=True))
        ]
        write_table(tmp_path / f"Tag {day}.csv", rows, names, ",")
    mapping = {
        "format": "scalar-mapping/1",
        "poses": {
            "files": [{"name": "Tag *.csv"}],
            "columns": {"time": {"column": "Clock"}, **joints(), **XYZ},
        },
        "dataset": description("tracker"),
    }
    imported(tmp_path, mapping, tmp_path)
    written = pd.read_csv(tmp_path / "out/poses.csv")["time"].tolist()
    assert written == [32_400.0 + k for k in range(4)] + [118_800.0 + k for k in range(5)]


@pytest.mark.parametrize("whole", [True, False])
def test_two_days_that_both_count_from_one_are_one_campaign(tmp_path, whole):
    """Files of the same name are told by their folder; numbers and sessions are stated for each file."""
    two_tables(tmp_path)
    for name in ("robot.csv", "tracker.csv"):
        lines = (tmp_path / name).read_text().splitlines()
        (tmp_path / name).unlink()
        for day, part in ((1, lines[1:6]), (2, lines[6:])):
            (tmp_path / f"Tag {day}").mkdir(exist_ok=True)
            anew = [f"{k + 1},{line.split(',', 1)[1]}" for k, line in enumerate(part)]
            (tmp_path / f"Tag {day}" / name).write_text("\n".join([lines[0], *anew, ""]))
    mapping = {
        "format": "scalar-mapping/1",
        "poses": {
            "files": [{"name": "Tag 1/robot.csv", "session": 1}, {"name": "Tag 2/robot.csv", "session": 2}],
            "columns": {"pose": {"column": "Nr"}, **joints()},
        },
        "points": {
            "files": [{"name": "Tag 1/tracker.csv"}, {"name": "Tag 2/tracker.csv", "add_to_pose": 5}],
            "columns": {"pose": {"column": "Nr"}, **XYZ},
        },
        "dataset": description("tracker"),
    }
    sources = [tmp_path] if whole else [tmp_path / "Tag 1", tmp_path / "Tag 2"]
    refused(tmp_path, run(tmp_path, mapping, *sources), "robot.csv, row 2", "stands already")
    mapping["poses"]["files"][1]["add_to_pose"] = 5
    data = imported(tmp_path, mapping, *sources)
    np.testing.assert_array_equal(data.pose_ids, np.arange(1, N + 1))
    np.testing.assert_array_equal(data.q, angles())
    np.testing.assert_allclose(data.points, places() / 1000, rtol=1e-12)
    assert list(data.poses["session"]) == ["1"] * 5 + ["2"] * 4
