"""Files that are called alike or given twice, names and numbers that look like others, and rows without a time."""

import numpy as np
import pandas as pd
import pytest
from openpyxl import Workbook

from scalar.ingest.imported_table import MEASURED_AT, ImportedTable
from scalar.ingest.matching import NearestTime, give_to_nearest
from scalar.ingest.written_times import read_times
from tests.ingest.foreign_tables import N, imported, joints, refused, run, write_table
from tests.ingest.test_merged_scans import POSES, Z, mapping
from tests.ingest.two_tables import XYZ, angles, by_time, places, two_tables
from tests.small_datasets import description

NAMES = [*(f"J{i}" for i in range(1, 7)), *"xyz"]


def one_table(columns=None, **of_mapping):
    """Return a mapping of poses with their points."""
    poses = {"columns": {**(columns or {}), **joints(), **XYZ}}
    return {"format": "scalar-mapping/1", "poses": poses, "dataset": description("tracker"), **of_mapping}


def rows(part=slice(None)):
    """Return joint angles and positions as text."""
    return [[*map(str, [*q, *p])] for q, p in zip(angles()[part], places()[part], strict=True)]


def with_reference(pattern):
    """Return rows of the tracker, whose poses are named by a pattern, with one reference point at the end."""
    named = [[pattern.format(k + 1), *map(str, row)] for k, row in enumerate(places())]
    return [*named, ["REF1", "1", "2", "3"]]


def test_two_days_in_files_of_one_name_stay_apart_in_time(tmp_path):
    """Both days begin at nine: the second day comes after the first, and its poses are not put between those of the first."""
    for day, part in ((1, slice(0, 4)), (2, slice(4, N))):
        (tmp_path / f"Tag {day}").mkdir()
        timed = [[f"9:00:0{k}", *row] for k, row in enumerate(rows(part))]
        write_table(tmp_path / f"Tag {day}" / "robot.csv", timed, ["Clock", *NAMES], ",")
    given = one_table({"time": {"column": "Clock"}})
    given["poses"]["files"] = [{"name": "Tag 1/robot.csv"}, {"name": "Tag 2/robot.csv"}]
    imported(tmp_path, given, tmp_path)
    assert pd.read_csv(tmp_path / "out/poses.csv")["order"].tolist() == list(range(N))


def test_a_file_that_two_sources_hold_is_read_once(tmp_path, monkeypatch):
    """A folder and a folder inside it, or a relative path to it, lead to the same file."""
    (tmp_path / "inner").mkdir()
    for k, row in enumerate(rows()):
        write_table(tmp_path / "inner" / f"Pose {k + 1}.csv", [row], NAMES, ",")
    given = one_table({"pose": {"column": "@file_number"}})
    given["poses"]["files"] = [{"name": "inner/Pose *.csv"}]
    monkeypatch.chdir(tmp_path)
    sources = [tmp_path, tmp_path / "inner", tmp_path.relative_to(tmp_path) / "inner"]
    np.testing.assert_array_equal(imported(tmp_path, given, *sources).q, angles())


def test_a_file_with_several_profiles_may_name_their_pose(tmp_path):
    """A scanner that repeats each profile writes the repetitions of a pose into one file: its rows are no scans of other poses."""
    write_table(tmp_path / "poses.csv", POSES, ["Nr", "Plane", *(f"J{i}" for i in range(1, 7))], ",")
    for k in range(len(POSES)):
        write_table(tmp_path / f"scan_{k + 1}.csv", [Z[k], Z[k]], [f"{x}.5" for x in range(-2, 3)], ",")
    columns = {"pose": {"column": "@file_number"}, **{c: {"column": f"@{c}", "unit": "mm"} for c in "xz"}}
    given = mapping("scan_*.csv", row_profiles={}, columns=columns)
    write_table(tmp_path / "scan_2.csv", [Z[1]] * 4, [f"{x}.5" for x in range(-2, 3)], ",")
    refused(tmp_path, run(tmp_path, given, tmp_path), "pose 2 has 4 scans", "scan_2.csv row 5")
    write_table(tmp_path / "scan_2.csv", [Z[1]] * 2, [f"{x}.5" for x in range(-2, 3)], ",")
    imported(tmp_path, given, tmp_path)
    counts = pd.read_csv(tmp_path / "out/scans.csv")["pose"].value_counts()
    assert counts.to_dict() == {k + 1: 10 for k in range(len(POSES))}


def test_whole_numbers_that_a_spreadsheet_holds_as_text_stay_text(tmp_path):
    """A decimal comma changes neither the names 1 to 6 of columns, nor the sessions 01 and 02, which ``names`` translates."""
    book = Workbook()
    sheet = book.active
    assert sheet is not None
    sheet.append(["Sitzung", *map(str, range(1, 7)), *"xyz"])
    for k, (q, place) in enumerate(zip(angles(), places(), strict=True)):
        german = [f"{value:.3f}".replace(".", ",") for value in place]
        sheet.append(["01" if k < 5 else "02", *(float(value) for value in q), *german])
    book.save(tmp_path / "a.xlsx")
    session = {"column": "Sitzung", "names": {"01": "before", "02": "after"}}
    given = one_table(text={"separator": ";", "decimal": ","})
    given["poses"]["columns"] |= {
        "session": session,
        **{f"q{i}": {"column": str(i), "unit": "rad"} for i in range(1, 7)},
    }
    data = imported(tmp_path, given, tmp_path / "a.xlsx")
    assert data.poses["session"].tolist() == ["before"] * 5 + ["after"] * 4
    np.testing.assert_allclose(data.points, places() / 1000, rtol=1e-12)


@pytest.mark.parametrize("pattern", ["P-{:03d}", "PR[{}]", "P*{}", "P{}"])
def test_the_proposed_pattern_keeps_the_poses(tmp_path, pattern):
    """What the message proposes can be copied, whatever signs the names contain."""
    given = two_tables(tmp_path, points=with_reference(pattern))
    said = run(tmp_path, given, tmp_path).stderr
    proposed = said.split("rows_like: {Nr: '")[1].split("'}")[0]
    given["points"]["rows_like"] = {"Nr": proposed}
    np.testing.assert_allclose(imported(tmp_path, given, tmp_path).points, places() / 1000, rtol=1e-12)


def test_rows_are_chosen_by_the_number_of_a_column_too(tmp_path):
    """As everywhere else in a mapping, a column without a name has a number."""
    given = two_tables(tmp_path, points=with_reference("P{}"))
    given["points"]["rows_like"] = {"1": "P[*]"}
    refused(tmp_path, run(tmp_path, given, tmp_path), "write [[] for this sign")
    given["points"]["rows_like"] = {"1": "P*"}
    assert len(imported(tmp_path, given, tmp_path).pose_ids) == N


def test_a_row_without_a_time_is_refused_with_a_remedy_that_exists(tmp_path):
    """``drop_without`` cannot name the time of points, but ``rows_like`` can."""
    given = by_time(tmp_path)
    path = tmp_path / "tracker.csv"
    lines = path.read_text().splitlines()
    lines[3] = "," + lines[3].split(",", 1)[1]
    path.write_text("\n".join([*lines, ""]))
    refused(tmp_path, run(tmp_path, given, tmp_path), "tracker.csv, row 4, column Nr", "rows_like")
    given["points"]["rows_like"] = {"Nr": "?*"}
    assert len(imported(tmp_path, given, tmp_path).pose_ids) == N - 2


def test_only_zeros_are_named_as_such(tmp_path):
    """It is not a missing cell that leaves no row."""
    given = two_tables(tmp_path, points=[[str(k + 1), "0", "0", "0"] for k in range(N)])
    given["points"]["drop_zeros"] = ["x", "y", "z"]
    refused(tmp_path, run(tmp_path, given, tmp_path), "x, y, z are 0 in every row, so that none is left")


@pytest.mark.parametrize("n_poses", [1, 2, 9])
def test_each_point_has_the_pose_of_which_the_time_is_nearest(n_poses):
    """The same as by comparing all pairs, for poses in any order and points before the first and after the last of them."""
    rng = np.random.default_rng(n_poses)

    def table(file, **columns):
        n = len(next(iter(columns.values())))
        return ImportedTable(file, columns, lambda: np.arange(n) + 2, files=np.full(n, file, dtype=object))

    clock, time = 10.0 * rng.permutation(n_poses) + rng.uniform(0, 1, n_poses), rng.uniform(-20, 110, 400)
    poses = table("poses.csv", pose=np.arange(n_poses, dtype=float), time=clock)
    faults, left_out = [], []
    points = table("points.csv", x=time, **{MEASURED_AT: time.copy()})
    found = give_to_nearest(points, poses, NearestTime("t", 3.0), faults, left_out)
    away = np.abs(time[:, None] - clock)
    near = away.min(axis=1) <= 3.0
    assert not faults and near.any() and not near.all()
    np.testing.assert_array_equal(found.columns["x"], time[near])
    np.testing.assert_array_equal(found.columns["pose"], away.argmin(axis=1)[near])


def test_lines_of_remarks_do_not_shift_the_line_that_a_fault_names(tmp_path):
    """The line of the names is the third one of the file."""
    given = two_tables(tmp_path)
    given["text"] = {"comment": "#"}
    path = tmp_path / "tracker.csv"
    path.write_text("# a\n# b\n" + path.read_text().replace("Nr,x,y,z", "Nr,x,y"))
    refused(tmp_path, run(tmp_path, given, tmp_path), "tracker.csv, row 3: the line that should name")


def test_positions_may_count_from_the_first_of_them(tmp_path):
    """The first row alone is then exactly 0; a second such row is not."""
    relative = places() - places()[0]
    given = two_tables(tmp_path, points=[[str(k + 1), *map(str, row)] for k, row in enumerate(relative)])
    imported(tmp_path, given, tmp_path)
    (tmp_path / "out").rename(tmp_path / "first")
    relative[4] = 0.0
    given = two_tables(tmp_path, points=[[str(k + 1), *map(str, row)] for k, row in enumerate(relative)])
    refused(tmp_path, run(tmp_path, given, tmp_path), "in 2 of 9 rows (2, 6)")


def test_dates_in_one_file_and_times_of_day_in_the_other_are_refused(tmp_path):
    """Nothing says on which day the times of the second file are."""
    for k, (part, stamp) in enumerate(((slice(0, 4), "26.11.2026 9:00:0"), (slice(4, N), "9:00:0"))):
        timed = [[f"{stamp}{i}", *row] for i, row in enumerate(rows(part))]
        write_table(tmp_path / f"Tag {k}.csv", timed, ["Clock", *NAMES], ",")
    given = one_table({"time": {"column": "Clock"}})
    given["poses"]["files"] = [{"name": "Tag *.csv"}]
    refused(tmp_path, run(tmp_path, given, tmp_path), "Tag 1.csv", "no dates", "Tag 0.csv")


@pytest.mark.parametrize(
    ("stamps", "seconds"),
    [
        (["23:59:30", "00:00:10,5"], [86_370.0, 86_410.5]),
        (["26.11.2026 9:04", "2026-11-26 09:04:30.5"], [32_640.0, 32_670.5]),
        (["2026-11-26T00:30:00+01:00", "2026-11-26T00:00:00Z"], [84_600.0, 86_400.0]),
        (["2026-11-26 09:04:30", "2026-11-26T08:04:30+01:00"], None),
        (["9:75:00", "9:76:00"], None),
        (["11:59:30 PM", "12:00:10.5 AM"], [86_370.0, 86_410.5]),
        (["12:00:00 p.m.", "1:00:00pm"], [43_200.0, 46_800.0]),
        (["13:00:00 PM", "1:00:00 PM"], None),
        (["0:30:00 AM"], None),
        (["9:00:00 AM", "9:00:00"], None),
        (["11/26/2026 9:04:30 AM", "11/26/2026 9:04:30 PM"], [32_670.0, 75_870.0]),
        (["26/11/2026 9:04:30", "27/11/2026 0:00"], [32_670.0, 86_400.0]),
        (["26-11-26 09:04", "27-11-26 09:04"], [32_640.0, 119_040.0]),
        (["2026/11/26 09:04:30,25", "2026/11/26, 09:04:31"], [32_670.25, 32_671.0]),
        (["26.11.26 09:04:30"], [32_670.0]),
        (["11/26/2026 9:04:30 AM", "11/26/2026 21:04:30"], None),
        (["31.02.2026 09:00:00", "31.02.2026 09:00:01"], None),
    ],
)
def test_times_are_read_only_if_they_mean_one_thing(stamps, seconds):
    """Times past midnight, in UTC with a zone; no minutes beyond 59, no day that does not exist, and no zones of some cells alone."""
    found = read_times(stamps)
    assert (found is None) if seconds is None else found is not None and found.seconds.tolist() == seconds
