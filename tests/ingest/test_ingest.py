"""Importing foreign tables: the same numbers in other words, and every refusal names its place."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner, Result
from scipy.io import savemat
from scipy.spatial.transform import Rotation

from scalar.cli import cli
from scalar.data.dataset import Dataset, read_dataset
from scalar.data.io.plain_yaml import dump_yaml, load_yaml
from tests.small_datasets import description

N = 9
ROOT = Path(__file__).parents[2]


def joints(unit: str = "rad") -> dict[str, Any]:
    """Return six columns of a mapping, J1 to J6."""
    return {f"q{i}": {"column": f"J{i}", "unit": unit} for i in range(1, 7)}


def tracker_mapping() -> dict[str, Any]:
    """Return the mapping of a table with degrees, millimetres, semicolons and decimal commas."""
    points = {f"{c}": {"column": f"tracker {c.upper()}", "unit": "mm"} for c in "xyz"}
    return {
        "format": "scalar-mapping/1",
        "text": {"separator": ";", "decimal": ","},
        "poses": {"columns": {**joints("deg"), **points}},
        "dataset": description("tracker"),
    }


def numbers() -> np.ndarray:
    """Return ``(N, 9)``: six joint angles [deg] and a position [mm], three decimals each."""
    rng = np.random.default_rng(3)
    return np.round(np.hstack([rng.uniform(-170, 170, (N, 6)), rng.uniform(-3000, 3000, (N, 3))]), 3)


def header() -> list[str]:
    """Return the names of the columns of `numbers`."""
    return [*(f"J{i}" for i in range(1, 7)), "tracker X", "tracker Y", "tracker Z"]


def cells() -> list[list[str]]:
    """Return `numbers` as a German spreadsheet writes them."""
    return [[f"{value:.3f}".replace(".", ",") for value in row] for row in numbers()]


def write_table(
    path: Path, rows: list[list[str]], names: list[str] | None = None, separator: str = ";"
) -> Path:
    """Write a table of text with Windows line ends."""
    lines = [separator.join(row) for row in [header() if names is None else names, *rows]]
    path.write_bytes(("\r\n".join(lines) + "\r\n").encode())
    return path


def run(folder: Path, mapping: dict[str, Any], *sources: Path) -> Result:
    """Run ``scalar import`` into ``folder/out``."""
    dump_yaml(mapping, folder / "mapping.yaml")
    command = ["import", str(folder / "mapping.yaml"), *map(str, sources), "-o", str(folder / "out")]
    return CliRunner().invoke(cli, command)


def imported(folder: Path, mapping: dict[str, Any], *sources: Path) -> Dataset:
    """Return the dataset that an import wrote."""
    result = run(folder, mapping, *sources)
    assert result.exit_code == 0, result.output
    return read_dataset(folder / "out")


def refused(folder: Path, result: Result, *words: str) -> None:
    """Check a refusal: exit status 2, one line a fault, the words, no traceback, nothing left behind."""
    assert result.exit_code == 2, result.output
    assert result.stdout == ""
    assert all(line.startswith("scalar: ") for line in result.stderr.splitlines())
    for word in words:
        assert word in result.stderr
    assert not (folder / "out").exists()
    assert not list(folder.glob(".out*"))


def test_other_units_separators_and_decimal_signs_give_the_same_numbers(tmp_path):
    """Degrees and millimetres become radians and metres, to the last digit that the file has."""
    data = imported(tmp_path, tracker_mapping(), write_table(tmp_path / "a.csv", cells()))
    given = numbers()
    np.testing.assert_allclose(data.q, np.radians(given[:, :6]), rtol=0, atol=1e-15)
    assert [[f"{1000 * x:.3f}" for x in row] for row in data.points] == [
        [f"{x:.3f}" for x in row] for row in given[:, 6:]
    ]
    written = (tmp_path / "out/points.csv").read_text().splitlines()[1]
    assert all(len(cell) <= len("-0.123456") for cell in written.split(",")), (
        "no digits that the file has not"
    )
    np.testing.assert_array_equal(data.pose_ids, np.arange(N))
    np.testing.assert_array_equal(data.poses["order"], np.arange(N))


def test_a_description_in_other_units_and_euler_angles_is_converted(tmp_path):
    """Inline or from a file, in mm and deg or in SI: the same dataset.yaml."""
    mapping = tracker_mapping()
    si = imported(tmp_path, mapping, write_table(tmp_path / "a.csv", cells()))
    robot = mapping["dataset"]["robot"]
    for joint in robot["joints"]:
        for key, factor in {"a": 1e3, "d": 1e3, "alpha": 180 / np.pi, "theta": 180 / np.pi}.items():
            joint[key] *= factor
    sensor = mapping["dataset"]["sensor"]
    sensor["noise"] *= 1e3
    angles = Rotation.from_rotvec([0.1, 0.0, 0.0]).as_euler("XYZ", degrees=True).tolist()
    sensor["nominal_pose"] = {
        "translation": [50.0, 20.0, 100.0],
        "rotation_euler": {"axes": "XYZ", "angles": angles},
    }
    mapping["dataset_units"] = {"length": "mm", "angle": "deg"}
    other = imported(tmp_path, mapping, tmp_path / "a.csv")
    np.testing.assert_allclose(other.robot.flange(si.q), si.robot.flange(si.q), atol=1e-13)
    assert other.sensor.T_flange_sensor is not None and si.sensor.T_flange_sensor is not None
    np.testing.assert_allclose(other.sensor.T_flange_sensor, si.sensor.T_flange_sensor, atol=1e-14)
    assert other.sensor.noise == pytest.approx(si.sensor.noise)
    dump_yaml(description("tracker"), tmp_path / "cell.yaml")
    mapping = tracker_mapping() | {"dataset": "cell.yaml"}
    imported(tmp_path, mapping, tmp_path / "a.csv")
    assert load_yaml(tmp_path / "out/dataset.yaml") == description("tracker")


def test_intrinsic_and_extrinsic_angles_are_told_apart(tmp_path):
    """Capitals turn about moving axes: R = Rx Ry Rz; small letters about fixed ones: R = Rz Ry Rx."""
    write_table(tmp_path / "a.csv", cells())
    found = []
    for axes in ("XYZ", "xyz"):
        mapping = tracker_mapping()
        euler = {"axes": axes, "angles": [0.3, -0.4, 0.5]}
        mapping["dataset"]["sensor"]["nominal_pose"] = {"translation": [0, 0, 0.1], "rotation_euler": euler}
        T = imported(tmp_path, mapping, tmp_path / "a.csv").sensor.T_flange_sensor
        assert T is not None
        found.append(T[:3, :3])
    c, s = np.cos([0.3, -0.4, 0.5]), np.sin([0.3, -0.4, 0.5])
    Rx = np.array([[1, 0, 0], [0, c[0], -s[0]], [0, s[0], c[0]]])
    Ry = np.array([[c[1], 0, s[1]], [0, 1, 0], [-s[1], 0, c[1]]])
    Rz = np.array([[c[2], -s[2], 0], [s[2], c[2], 0], [0, 0, 1]])
    np.testing.assert_allclose(found[0], Rx @ Ry @ Rz, atol=1e-14)
    np.testing.assert_allclose(found[1], Rz @ Ry @ Rx, atol=1e-14)


def test_sign_and_offset_of_a_joint(tmp_path):
    """``ours = sign * theirs + offset``, the offset in the file's unit."""
    mapping = tracker_mapping()
    mapping["poses"]["columns"]["q2"] |= {"sign": -1, "offset": 90}
    data = imported(tmp_path, mapping, write_table(tmp_path / "a.csv", cells()))
    np.testing.assert_allclose(data.q[:, 1], np.radians(90 - numbers()[:, 1]), atol=1e-15)


def test_rows_without_a_measurement_are_left_out_where_asked_and_refused_otherwise(tmp_path):
    """An empty cell and a text that means 'none' are no measurement; other rows keep their numbers."""
    rows = cells()
    rows[2][7], rows[5][6] = "", "-9999"
    mapping = tracker_mapping()
    mapping["text"]["missing"] = ["-9999"]
    write_table(tmp_path / "a.csv", rows)
    refused(tmp_path, run(tmp_path, mapping, tmp_path / "a.csv"), "a.csv, row 4, column tracker Y", "row 7")
    mapping["poses"]["drop_without"] = ["x", "y", "z"]
    data = imported(tmp_path, mapping, tmp_path / "a.csv")
    np.testing.assert_allclose(data.q, np.radians(np.delete(numbers()[:, :6], [2, 5], axis=0)), atol=1e-15)


def test_optional_columns_covariates_and_preamble(tmp_path):
    """All come along; order sorts; lines before the table are skipped."""
    rows = [[*row, str(20 + i), f"{i},5", "ab"[i % 2], str(N - i)] for i, row in enumerate(cells())]
    write_table(tmp_path / "a.csv", rows, [*header(), "T", "t", "shift", "n"])
    path = tmp_path / "a.csv"
    path.write_bytes(b"a tracker's words\r\n\r\n" + path.read_bytes())
    mapping = tracker_mapping()
    mapping["text"]["skip_lines"] = 1
    mapping["poses"]["columns"] |= {
        "temperature": {"column": "T", "unit": "degC"},
        "time": {"column": "t", "unit": "s"},
        "session": {"column": "shift", "names": {"a": "early", "b": "late"}},
        "order": {"column": "n"},
    }
    mapping["poses"]["covariates"] = {"load": {"column": 10}}
    data = imported(tmp_path, mapping, path)
    np.testing.assert_array_equal(data.pose_ids, np.arange(N)[::-1])
    np.testing.assert_array_equal(data.poses["temperature"], 20 + np.arange(N)[::-1])
    np.testing.assert_array_equal(data.poses["load"], data.poses["temperature"])
    np.testing.assert_array_equal(data.poses["time"], np.arange(N)[::-1] + 0.5)
    assert list(data.poses["session"][-2:]) == ["late", "early"]


def matrix(seed: int, first: int) -> np.ndarray:
    """Return several rows a pose: id, camera, six angles [rad]."""
    rng = np.random.default_rng(seed)
    ids = np.repeat(np.arange(first, first + 5), [3, 1, 2, 4, 2])
    q = rng.uniform(-2, 2, (5, 6))
    return np.column_stack([ids, rng.uniform(0, 1, len(ids)), q[ids - first]])


def mat_mapping() -> dict[str, Any]:
    """Return the mapping of three matrices, each a plane's."""
    names = {"floor": "one.mat", "wall_x": "two.mat", "wall_y": "three.mat"}
    files = [
        {"name": f, "plane": p, "covariates": {"repetition": i}} for i, (p, f) in enumerate(names.items())
    ]
    columns = {f"q{i}": {"column": i + 2, "unit": "rad"} for i in range(1, 7)}
    return {
        "format": "scalar-mapping/1",
        "matrix": {"variable": "dataset"},
        "poses": {"files": files, "first_of_each": 1, "columns": columns},
        "dataset": description("probe"),
    }


def write_matrices(folder: Path) -> list[np.ndarray]:
    """Write the three matrices, ids beginning anew in each, and return them."""
    found = [matrix(i, first=1) for i in range(3)]
    for name, content in zip(("one", "two", "three"), found, strict=True):
        savemat(folder / f"{name}.mat", {"dataset": content, "other": 1.0})
    return found


def test_a_matrix_with_several_rows_a_pose(tmp_path):
    """The first row of each id is the pose; files follow one another as the mapping lists them."""
    given = write_matrices(tmp_path)
    data = imported(tmp_path, mat_mapping(), tmp_path)
    first = np.concatenate([content[np.unique(content[:, 0], return_index=True)[1]] for content in given])
    np.testing.assert_array_equal(data.q, first[:, 2:])
    assert list(data.poses["plane"]) == [name for name in ("floor", "wall_x", "wall_y") for _ in range(5)]
    np.testing.assert_array_equal(data.poses["repetition"], np.repeat([0, 1, 2], 5))
    np.testing.assert_array_equal(data.pose_ids, np.arange(15))
    shuffled = [tmp_path / name for name in ("three.mat", "one.mat", "two.mat")]
    np.testing.assert_array_equal(imported(tmp_path, mat_mapping(), *shuffled).q, data.q)


def test_first_of_each_does_not_join_poses_that_differ(tmp_path):
    """Rows that share an id and not their angles are two poses: named, not lost."""
    given = write_matrices(tmp_path)[1]
    given[2, 4] += 0.5
    savemat(tmp_path / "two.mat", {"dataset": given})
    refused(tmp_path, run(tmp_path, mat_mapping(), tmp_path), "two.mat, row 3, column 5", "q3", "row 1")


def test_scans_in_one_table_or_in_two_are_the_same(tmp_path):
    """A long table with a row a point, and poses and points in files of their own, give one dataset."""
    rng = np.random.default_rng(5)
    q, xz = rng.uniform(-2, 2, (6, 6)), rng.uniform(1, 200, (6, 4, 2))
    planes = ["floor", "wall_x", "wall_y"] * 2
    names = ["scan", "target", *(f"J{i}" for i in range(1, 7))]
    short = [[str(k), planes[k], *map(repr, map(float, q[k]))] for k in range(6)]
    points = [[str(k), *(repr(float(v)) for v in point)] for k in range(6) for point in xz[k]]
    write_table(tmp_path / "poses.csv", short, names, ",")
    write_table(tmp_path / "scans.csv", points, ["scan", "x", "z"], ",")
    long = [[*short[int(row[0])], *row[1:]] for row in points]
    write_table(tmp_path / "long.csv", long, [*names, "x", "z"], ",")
    coordinates = {"x": {"column": "x", "unit": "mm"}, "z": {"column": "z", "unit": "mm"}}
    columns = {"pose": {"column": "scan"}, "plane": {"column": "target"}, **joints()}
    mapping = {
        "format": "scalar-mapping/1",
        "poses": {"columns": {**columns, **coordinates}, "first_of_each": "scan"},
        "dataset": description("line-laser"),
    }
    one = imported(tmp_path, mapping, tmp_path / "long.csv")
    mapping["poses"] = {"columns": columns, "files": [{"name": "poses.csv"}]}
    mapping["points"] = {
        "columns": {"pose": {"column": "scan"}, **coordinates},
        "files": [{"name": "sc*.csv"}],
    }
    two = imported(tmp_path, mapping, tmp_path)
    np.testing.assert_allclose(one.points, xz.reshape(-1, 2) / 1000, rtol=1e-14)
    np.testing.assert_array_equal(one.points, two.points)
    np.testing.assert_array_equal(one.starts, two.starts)
    np.testing.assert_array_equal(one.q, q)
    np.testing.assert_array_equal(two.q, q)


def changed(path: tuple[str, ...], value: Any) -> dict[str, Any]:
    """Return the tracker's mapping with one key set, or removed where the value is None."""
    mapping = tracker_mapping()
    inner: Any = mapping
    for key in path[:-1]:
        inner = inner.setdefault(key, {})
    if value is None:
        del inner[path[-1]]
    else:
        inner[path[-1]] = value
    return mapping


@pytest.mark.parametrize(
    ("path", "value", "words"),
    [
        (("matrixx",), {}, ("matrixx", "did you mean 'matrix'")),
        (("text", "seperator"), ";", ("text.seperator", "unknown key", "separator")),
        (("text", "separator"), None, ("text.decimal", "separator")),
        (("text", "skip_lines"), -1, ("text.skip_lines", "less than 0")),
        (("format",), "scalar-mapping/2", ("format", "scalar-mapping/1")),
        (("poses", "columns", "q1", "unit"), "degrees", ("poses.columns.q1.unit", "did you mean 'deg'")),
        (("poses", "columns", "q1", "unit"), None, ("poses.columns.q1.unit", "missing", "rad or deg")),
        (("poses", "columns", "x", "unit"), "inch", ("poses.columns.x.unit", "m, mm")),
        (("poses", "columns", "x", "offset"), 1.0, ("poses.columns.x.offset", "only joints")),
        (("poses", "columns", "q1", "sign"), 2, ("poses.columns.q1.sign", "1, -1")),
        (("poses", "columns", "q1", "offset"), float("nan"), ("poses.columns.q1.offset", "finite")),
        (("poses", "columns", "q3"), None, ("poses.columns.q3", "missing")),
        (("poses", "columns", "q7"), {"column": "J7", "unit": "deg"}, ("poses.columns.q7", "unknown column")),
        (("poses", "columns", "temprature"), {"column": "T"}, ("did you mean 'temperature'",)),
        (("poses", "drop_without"), ["w"], ("poses.drop_without[0]",)),
        (("poses", "covariates", "q9"), {"column": "T"}, ("poses.covariates.q9",)),
        (("poses", "columns", "q1", "column"), "J8", ("a.csv", "column J8", "no such column", "J1")),
        (("poses", "columns", "q1", "column"), 12, ("a.csv", "no column 12", "9")),
        (("poses", "files"), [{"name": "b.csv"}], ("b.csv", "not among the sources")),
        (("dataset", "sensor", "kind"), "trakker", ("dataset.sensor.kind", "did you mean 'tracker'")),
        (("dataset", "robot", "joints"), [], ("dataset.robot.joints",)),
        (("dataset",), "missing.yaml", ("missing.yaml", "no such file")),
        (("dataset",), "../dataset.yaml", ("mapping.yaml, dataset", "leads out of the folder")),
        (("dataset",), "/etc/hostname", ("mapping.yaml, dataset", "leads out of the folder")),
        (("poses", "files"), [{"name": "../a.csv"}], ("../a.csv", "not among the sources")),
        (("poses", "files"), [{"name": "/etc/hostname"}], ("/etc/hostname", "not among the sources")),
        (("dataset_units", "length"), "cm", ("dataset_units.length", "m, mm")),
        (("dataset_units", "length"), "mm", ("dataset.", "mapping.yaml")),
    ],
)
def test_a_wrong_mapping_is_refused_by_name(tmp_path, path, value, words):
    """Key, column or unit stand in the message, with what could have been meant."""
    table = write_table(tmp_path / "a.csv", cells())
    mapping = changed(path, value)
    refused(tmp_path, run(tmp_path, mapping, table), *words)


@pytest.mark.parametrize(
    ("row", "column", "text", "words"),
    [
        (3, 1, "abc", ("a.csv, row 5, column J2", "abc")),
        (3, 1, "1.5", ("a.csv, row 5, column J2", "decimal: ','")),
        (3, 1, "1.234,5", ("a.csv, row 5, column J2",)),
        (0, 0, "1e999", ("a.csv, row 2, column J1", "finite")),
        (0, 8, "", ("a.csv, row 2, column tracker Z", "empty")),
        (4, 3, "90000", ("a.csv, row 6, column J4", "suspect")),
        (2, 6, "1;2", ("a.csv, row 4", "10 cells where 9")),
        (2, 6, '"1', ("a.csv", "quotes")),
    ],
)
def test_a_wrong_cell_is_named_by_row_and_column_of_its_own_file(tmp_path, row, column, text, words):
    """As an editor shows the foreign file, in that file's names."""
    rows = cells()
    rows[row][column] = text
    refused(tmp_path, run(tmp_path, tracker_mapping(), write_table(tmp_path / "a.csv", rows)), *words)


def test_a_decimal_comma_that_the_mapping_forgot_is_said_briefly(tmp_path):
    """Every cell of nine columns is wrong for one cause: ten lines a column and a count, and the key that cures it."""
    mapping = tracker_mapping()
    del mapping["text"]["decimal"]
    rows = cells() * 5
    result = run(tmp_path, mapping, write_table(tmp_path / "a.csv", rows))
    refused(
        tmp_path, result, "write decimal: ',' under text", f"{len(rows) - 10} more rows with the same fault"
    )
    assert len(result.stderr.splitlines()) == 11 * len(rows[0])


def test_all_faults_of_all_files_are_said_at_once(tmp_path):
    """A user repairs them in one round."""
    rows = cells()
    rows[1][1] = "x"
    one = write_table(tmp_path / "a.csv", rows)
    rows = cells()
    rows[2][2] = "y"
    two = write_table(tmp_path / "b.csv", rows)
    result = run(tmp_path, tracker_mapping(), one, two)
    refused(tmp_path, result, "a.csv, row 3, column J2", "b.csv, row 4, column J3")


def test_an_id_that_stands_twice_is_refused_across_files(tmp_path):
    """Files that count their poses from the same number cannot both keep their ids."""
    rows = [[str(i), *row] for i, row in enumerate(cells())]
    names = ["id", *header()]
    files = [write_table(tmp_path / name, rows, names) for name in ("a.csv", "b.csv")]
    mapping = tracker_mapping()
    mapping["poses"]["columns"]["pose"] = {"column": "id"}
    refused(tmp_path, run(tmp_path, mapping, *files), "b.csv, row 2, column id", "pose 0 stands already")
    rows[3][0] = "2,5"
    result = run(tmp_path, mapping, write_table(tmp_path / "a.csv", rows, names))
    refused(tmp_path, result, "a.csv, row 5, column id", "not an integer")


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", ("a.csv", "no rows")),
        (b"J1;J2\r\n", ("a.csv", "no rows")),
        (b"\xff\xfe\x00;\xd8", ("a.csv", "not utf-8")),
        (b"a,b,c\n1,2,3\n", ("a.csv", "separator")),
        (b"\x00\x00\x00", ("a.csv",)),
    ],
)
def test_a_file_that_is_no_table_is_refused(tmp_path, content, words):
    """Empty, of another encoding, of another separator, or no text at all."""
    (tmp_path / "a.csv").write_bytes(content)
    refused(tmp_path, run(tmp_path, tracker_mapping(), tmp_path / "a.csv"), *words)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ({"dataset": np.zeros((0, 8))}, ("no rows",)),
        ({"dataset": np.zeros((3, 4))}, ("no column 8", "4")),
        ({"data": np.zeros((3, 8))}, ("no variable 'dataset'",)),
        ({"dataset": "text"}, ("not a matrix",)),
        ({"dataset": {"a": 1.0}}, ("not a matrix",)),
        ({"dataset": np.full((1, 8), np.nan)}, ("row 1, column 3", "empty")),
        (b"MATLAB 7.3 MAT-file, or so", ("damaged",)),
        (b"", ("damaged",)),
    ],
)
def test_a_matrix_that_is_none_is_refused(tmp_path, content, words):
    """By file, and by row and column where there are any."""
    write_matrices(tmp_path)
    if isinstance(content, bytes):
        (tmp_path / "two.mat").write_bytes(content)
    else:
        savemat(tmp_path / "two.mat", content)
    refused(tmp_path, run(tmp_path, mat_mapping(), tmp_path), "two.mat", *words)


def test_a_source_that_is_missing_or_not_meant_is_refused(tmp_path):
    """No such file; a file that the mapping does not name; a folder for a mapping that names no files."""
    write_matrices(tmp_path)
    refused(tmp_path, run(tmp_path, tracker_mapping(), tmp_path / "none.csv"), "none.csv", "no such file")
    refused(tmp_path, run(tmp_path, tracker_mapping(), tmp_path), str(tmp_path), "names no files")
    other = write_table(tmp_path / "a.csv", cells())
    refused(tmp_path, run(tmp_path, mat_mapping(), tmp_path, other), "a.csv", "no such file, only one.mat")
    (tmp_path / "two.mat").unlink()
    refused(tmp_path, run(tmp_path, mat_mapping(), tmp_path), "two.mat", "not among the sources")


def test_an_import_never_replaces_what_is_no_dataset(tmp_path):
    """A folder with something else in it stays as it is; a dataset is replaced whole."""
    table = write_table(tmp_path / "a.csv", cells())
    (tmp_path / "out").mkdir()
    (tmp_path / "out/thesis.txt").write_text("mine")
    result = run(tmp_path, tracker_mapping(), table)
    assert result.exit_code == 2
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["thesis.txt"]


@pytest.mark.parametrize(
    "path", sorted((ROOT / "configs/measured").glob("*.yaml")), ids=lambda path: path.stem
)
def test_the_example_mappings_are_sound(path):
    """Each loads without a fault, for a robot whose nominal arm reaches as far as such a robot does."""
    from scalar.geometry.robot import Robot
    from scalar.ingest.mapping_reader import load_mapping

    mapping = load_mapping(path)
    robot = Robot.from_mapping(mapping.description.mapping["robot"])
    reach = np.linalg.norm(robot.flange(np.zeros((1, robot.n_joints)))[0, :3, 3])
    assert 0.5 < reach < 3.0


@pytest.mark.parametrize(
    "edit, key",
    [
        (lambda m: m["poses"]["columns"]["q1"].update(column=1.0), "column"),
        (lambda m: m["dataset"]["robot"]["joints"][0].update(a=int("9" * 390)), "joints[0].a"),
    ],
)
def test_an_integer_has_no_point_and_no_number_has_hundreds_of_digits(
    edit: Any, key: str, tmp_path: Path
) -> None:
    """A column's number with a point, and a length too large to compute with, are refused by their keys."""
    mapping = {**tracker_mapping(), "dataset_units": {"length": "mm", "angle": "deg"}}
    edit(mapping)
    dump_yaml(mapping, tmp_path / "mapping.yaml")
    write_table(tmp_path / "table.csv", cells())
    result = CliRunner().invoke(
        cli,
        [
            "import",
            *(str(tmp_path / name) for name in ("mapping.yaml", "table.csv")),
            "-o",
            str(tmp_path / "d"),
        ],
    )
    assert result.exit_code == 2, result.output
    assert key in result.stderr


def whole_poses(folder: Path, kind: str) -> tuple[dict[str, Any], np.ndarray]:
    """Return the mapping of a table with orientations of that kind, which it writes, and their rotation vectors ``(N, 3)`` [rad]."""
    turns = Rotation.random(N, np.random.default_rng(4))
    mapping = tracker_mapping()
    columns = mapping["poses"]["columns"]
    if kind == "qwxyz":
        values = turns.as_quat()[:, [3, 0, 1, 2]] * np.where(np.arange(N) % 2, -1, 1)[:, None]
        names = ["qw", "qx", "qy", "qz"]
        columns |= {name: {"column": name} for name in names}
    elif kind == "vector":
        values, names = np.degrees(turns.as_rotvec()), ["rx", "ry", "rz"]
        columns |= {name: {"column": name, "unit": "deg"} for name in names}
    else:
        values, names = turns.as_euler(kind, degrees=True), ["A", "B", "C"]
        columns |= {f"e{k + 1}": {"column": name, "unit": "deg"} for k, name in enumerate(names)}
        mapping["poses"]["euler_axes"] = kind
    rows = [
        [*row, *(f"{x:.12f}".replace(".", ",") for x in more)]
        for row, more in zip(cells(), values, strict=True)
    ]
    write_table(folder / "a.csv", rows, [*header(), *names])
    return mapping, turns.as_rotvec()


@pytest.mark.parametrize("kind", ["ZYX", "xyz", "ZXZ", "qwxyz", "vector"])
def test_orientations_become_rotation_vectors(tmp_path, kind):
    """Euler angles about moving and fixed axes, quaternions of either sign and vectors in degrees are the same turns in the dataset."""
    mapping, wanted = whole_poses(tmp_path, kind)
    data = imported(tmp_path, mapping, tmp_path / "a.csv")
    found = np.column_stack([data.point_columns[name] for name in ("rx", "ry", "rz")])
    np.testing.assert_allclose(
        Rotation.from_rotvec(found).as_matrix(), Rotation.from_rotvec(wanted).as_matrix(), atol=1e-11
    )
    assert not {"e1", "qw"} & set(data.poses.columns)


@pytest.mark.parametrize(
    "change, words",
    [
        (lambda p: p.pop("euler_axes"), "poses.euler_axes: missing; add it: ZYX"),
        (lambda p: p.update(euler_axes="ZZX"), "axes 'ZZX' are not three such as XYZ"),
        (lambda p: p["columns"].pop("e2"), "missing; add it: e1,e2,e3 come together"),
        (
            lambda p: p["columns"].update(rx={"column": "A", "unit": "deg"}),
            "state the same orientation twice",
        ),
        (lambda p: p["columns"]["e1"].pop("unit"), "poses.columns.e1.unit: missing; add it"),
    ],
)
def test_an_orientation_that_is_not_clear_is_refused(tmp_path, change, words):
    """No convention is guessed, and none is half stated."""
    mapping, _ = whole_poses(tmp_path, "ZYX")
    change(mapping["poses"])
    refused(tmp_path, run(tmp_path, mapping, tmp_path / "a.csv"), words)


def test_a_quaternion_that_is_none_is_refused_by_its_row(tmp_path):
    """Numbers whose squares do not sum to one are no quaternion."""
    mapping, _ = whole_poses(tmp_path, "qwxyz")
    lines = (tmp_path / "a.csv").read_text().splitlines()
    lines[3] = ";".join([*lines[3].split(";")[:-4], "0,5", "0", "0", "0"])
    (tmp_path / "a.csv").write_text("\n".join(lines))
    refused(
        tmp_path, run(tmp_path, mapping, tmp_path / "a.csv"), "a.csv, row 4, column qw", "has the norm 0.5"
    )


def test_nests_are_imported(tmp_path):
    """A table of nests in millimetres becomes nests.csv; a nest of an unknown pose is refused by its row."""
    mapping = tracker_mapping()
    mapping["poses"]["columns"]["pose"] = {"column": "Pose"}
    mapping["poses"]["files"] = [{"name": "a.csv"}]
    mapping["nests"] = {
        "files": [{"name": "nests.csv"}],
        "columns": {
            "pose": {"column": "Pose"},
            "nest": {"column": "Nest"},
            **{c: {"column": c.upper(), "unit": "mm"} for c in "xyz"},
        },
    }
    rows = [[str(i + 1), *row] for i, row in enumerate(cells())]
    write_table(tmp_path / "a.csv", rows, ["Pose", *header()])
    nests = [
        [str(i + 1), name, f"{1000 * k},5", "2000", "0"] for i in range(N) for k, name in enumerate("ABC")
    ]
    write_table(tmp_path / "nests.csv", nests, ["Pose", "Nest", "X", "Y", "Z"])
    data = imported(tmp_path, mapping, tmp_path / "a.csv", tmp_path / "nests.csv")
    assert data.references is not None and data.references.names == ("A", "B", "C")
    np.testing.assert_allclose(data.references.points[1], [1.0005, 2.0, 0.0], atol=1e-15)
    assert len(data.references.pose) == 3 * N
    write_table(tmp_path / "nests.csv", [["77", "A", "0", "0", "0"]], ["Pose", "Nest", "X", "Y", "Z"])
    result = run(tmp_path, mapping, tmp_path / "a.csv", tmp_path / "nests.csv")
    assert (
        result.exit_code == 2 and "nests.csv, row 2" in result.stderr and "unknown pose 77" in result.stderr
    )
