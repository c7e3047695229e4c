"""Two scans are never made one profile of a pose, whether they are rows of a table or files of their own."""

import pytest

from tests.ingest.foreign_tables import imported, joints, refused, run, write_table
from tests.small_datasets import description

PLANES = ["floor", "wall_x", "wall_y"] * 2
POSES = [
    [str(k + 1), plane, *(f"{0.1 * k + i / 10:.4f}" for i in range(6))] for k, plane in enumerate(PLANES)
]
Z = [[f"{200 + 7 * k + i * i:.1f}" for i in range(5)] for k in range(7)]


def mapping(files, **of_points):
    """Return a mapping of poses in poses.csv and points in other files."""
    return {
        "format": "scalar-mapping/1",
        "poses": {
            "files": [{"name": "poses.csv"}],
            "columns": {"pose": {"column": "Nr"}, "plane": {"column": "Plane"}, **joints()},
        },
        "points": {"files": [{"name": files}], **of_points},
        "dataset": description("line-laser"),
    }


def in_rows(folder, numbers):
    """Write a table with a profile in each row, of the poses of these numbers, and return the mapping."""
    write_table(folder / "poses.csv", POSES, ["Nr", "Plane", *(f"J{i}" for i in range(1, 7))], ",")
    rows = [[str(number), *Z[k % len(Z)]] for k, number in enumerate(numbers)]
    write_table(folder / "LJ.csv", rows, ["No.", *(f"{x}.5" for x in range(-2, 3))], ",")
    columns = {"pose": {"column": "No."}, **{c: {"column": f"@{c}", "unit": "mm"} for c in "xz"}}
    return mapping("LJ.csv", row_profiles={}, columns=columns)


def test_a_profile_that_stands_twice_is_refused(tmp_path):
    """One profile for each pose but one, which has two: the message names both rows."""
    refused(
        tmp_path,
        run(tmp_path, in_rows(tmp_path, [1, 2, 3, 4, 4, 5, 6]), tmp_path),
        "pose 4 has 2 scans",
        "row 5",
        "row 6",
    )


def test_poses_with_equally_many_profiles_are_taken(tmp_path):
    """A scanner may repeat each profile."""
    data = imported(tmp_path, in_rows(tmp_path, [k for k in range(1, 7) for _ in range(2)]), tmp_path)
    assert [stop - start for start, stop in zip(data.starts[:-1], data.starts[1:], strict=True)] == [10] * 6


@pytest.mark.parametrize("copies", [1, 6])
def test_two_files_of_one_number_are_refused(tmp_path, copies):
    """The scans of another day, which differ by noise, have the numbers of poses that have their scans already."""
    use = in_rows(tmp_path, [1])
    (tmp_path / "day 2").mkdir()
    for k in range(6 + copies):
        path = tmp_path / f"Scan {k + 1}.csv" if k < 6 else tmp_path / "day 2" / f"Scan {k - 5}.csv"
        noise = 0.0 if k < 6 else 0.1
        write_table(
            path, [[f"{i}", f"{float(z) + noise:.1f}"] for i, z in enumerate(Z[k % 6])], ["x", "z"], ","
        )
    columns = {"pose": {"column": "@file_number"}, **{c: {"column": c, "unit": "mm"} for c in "xz"}}
    use["points"] = {"files": [{"name": "Scan *.csv"}], "columns": columns}
    assert run(tmp_path, use, tmp_path).exit_code == 0
    result = run(tmp_path, use, tmp_path, tmp_path / "day 2")
    assert (
        result.exit_code == 2
        and f"pose 1 has 2 scans ({tmp_path.name}/Scan 1.csv, day 2/Scan 1.csv)" in result.stderr
    )
