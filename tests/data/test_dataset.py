"""A dataset reads back as it was written, its points grouped by pose, its poses in acquisition order."""

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from scalar.data.dataset import Dataset, read_dataset, validate_dataset
from scalar.data.dataset_writer import write_dataset
from scalar.errors import InvalidInput
from tests.small_datasets import PLANES, description, edit_cell, edit_lines, tables

IN_ONE_FOLDER = settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=40)
LENGTHS = st.floats(-15.0, 15.0)  # m, with every bit pattern in between


def write_and_read(folder: Path, mapping: dict[str, Any], **content: Any) -> Dataset:
    """Return the dataset that comes back from a folder."""
    write_dataset(folder / "d", mapping=mapping, **content)
    return read_dataset(folder / "d")


@IN_ONE_FOLDER
@given(
    scans=hnp.arrays(
        float, st.tuples(st.integers(9, 30), st.just(2)), elements=LENGTHS, unique=True
    ),  # a value in several scans is suspected to mark missing ones
    q=hnp.arrays(float, (9, 6), elements=st.floats(-6.0, 6.0)),
    table_format=st.sampled_from(["csv", "parquet"]),
    seed=st.integers(0, 2**32 - 1),
)
def test_numbers_read_back_exactly(
    tmp_path: Path, scans: np.ndarray, q: np.ndarray, table_format: str, seed: int
) -> None:
    """``read(write(x)) == x`` holds to the last bit, in CSV and Parquet, and each pose has its points in file order."""
    poses = tables()["poses"]
    poses[[f"q{i + 1}" for i in range(6)]] = q
    rng = np.random.default_rng(seed)
    owner = rng.permutation(np.concatenate([np.arange(9), rng.integers(0, 9, len(scans) - 9)]))
    frame = pd.DataFrame({"pose": poses["pose"].to_numpy()[owner], "x": scans[:, 0], "z": scans[:, 1]})
    back = write_and_read(tmp_path, description(), poses=poses, scans=frame, table_format=table_format)
    assert np.array_equal(back.q, q)
    assert back.points.dtype == np.float64
    for i in range(9):
        assert np.array_equal(back.points[back.starts[i] : back.starts[i + 1]], scans[owner == i])


@pytest.mark.parametrize("table_format", ["csv", "parquet"])
def test_same_content_same_bytes(tmp_path: Path, table_format: str) -> None:
    """Two folders of the same content are the same, byte for byte."""
    for name in ("a", "b"):
        write_dataset(tmp_path / name, mapping=description(), table_format=table_format, **tables())
    files = sorted(item.name for item in (tmp_path / "a").iterdir())
    assert files == ["dataset.yaml", "poses.csv", f"scans.{table_format}"]
    for name in files:
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()


def test_a_line_laser_dataset_has_what_its_description_states(tmp_path: Path) -> None:
    """The dataset holds what its description states."""
    mapping = description()
    mapping["planes"][1] |= {"normal": [0.0, 2.0, 0.0], "known": {"distance_std": 1e-5, "normal_std": 1e-4}}
    back = write_and_read(tmp_path, mapping, **tables())
    assert (back.name, back.source, back.n_poses, back.sensor.kind) == ("small", "", 9, "line-laser")
    assert (back.sensor.noise, back.sensor.error_axis) == (1e-4, "ray")
    assert back.sensor.T_flange_sensor is not None
    assert np.array_equal(back.sensor.T_flange_sensor[:3, 3], [0.05, 0.02, 0.1])
    assert [plane.name for plane in back.planes] == list(PLANES)
    assert back.plane_index.tolist() == [0, 1, 2] * 3
    assert back.pose_ids.tolist() == list(range(10, 19))
    assert (back.planes[0].distance_std, back.planes[0].normal_std) == (None, None)
    # normal . p = distance, divided by the length of the normal, is the same plane
    assert back.planes[1].normal.tolist() == [0.0, 1.0, 0.0]
    assert (back.planes[1].distance, back.planes[1].distance_std) == (0.25, 0.5e-5)
    assert back.session is None
    assert back.covariates == ()


def test_a_probe_has_no_points(tmp_path: Path) -> None:
    """The measured point of a probe is its origin, so its dataset has no file of points."""
    back = write_and_read(tmp_path, description("probe"), **tables("probe"))
    assert back.points.shape == (0, 2)
    assert back.starts.tolist() == [0] * 10


def test_a_tracker_has_one_point_a_pose_and_no_planes(tmp_path: Path) -> None:
    """Row i of the points belongs to row i of the poses, whatever the order of the file, and planes are ignored."""
    content = tables("tracker")
    shuffled = content["points"].sample(frac=1.0, random_state=3)
    mapping = description("tracker") | {"planes": description()["planes"][:1]}
    back = write_and_read(tmp_path, mapping, poses=content["poses"], points=shuffled)
    assert np.array_equal(back.points, content["points"][["x", "y", "z"]].to_numpy())
    assert back.starts.tolist() == list(range(10))
    assert back.plane_index.tolist() == [-1] * 9
    assert back.planes == ()


def test_order_decides_over_the_rows_of_the_file(tmp_path: Path) -> None:
    """With a column `order` the poses are sorted by it, and the points go with them."""
    content = tables()
    order = np.random.default_rng(5).permutation(9)
    plain = write_and_read(tmp_path, description(), **content)
    ordered = write_and_read(
        tmp_path, description(), poses=content["poses"].assign(order=order * 10.0), scans=content["scans"]
    )
    rows = np.argsort(order)
    assert np.array_equal(ordered.q, plain.q[rows])
    assert np.array_equal(ordered.points, plain.points.reshape(9, 4, 2)[rows].reshape(-1, 2))


@pytest.mark.parametrize(
    ("labels", "codes"),
    [
        (["b", "b", "a", "b", "c", "a", "a", "b", "c"], [0, 0, 1, 0, 2, 1, 1, 0, 2]),
        ([2, 2, 1, 2, 2, 2, 2, 2, 2], [0, 0, 1, 0, 0, 0, 0, 0, 0]),
        (["1", "1.0", "x", "1", "1", "1", "1", "1", "1"], [0, 1, 2, 0, 0, 0, 0, 0, 0]),
        (["1", "1.0", "2", "1", "1", "1", "1", "1", "1"], [0, 0, 1, 0, 0, 0, 0, 0, 0]),
    ],
)
def test_sessions_are_coded_as_they_appear(tmp_path: Path, labels: list[Any], codes: list[int]) -> None:
    """Sessions may be text or numbers; if all are numbers, 1 and 1.0 are one session."""
    content = tables()
    content["poses"]["session"] = labels
    assert (write_and_read(tmp_path, description(), **content).session == codes).all()


def test_other_numeric_columns_are_kept_as_covariates(tmp_path: Path) -> None:
    """A numeric column that the format does not know is neither lost nor refused."""
    content = tables()
    extra = {"time": 1.5, "humidity": 0.4, "temperature": 21.0, "repetition": 2}
    extra |= {f"approach{i}": -1 for i in range(1, 7)}
    back = write_and_read(
        tmp_path, description(), poses=content["poses"].assign(**extra), scans=content["scans"]
    )
    assert back.covariates == ("humidity", "repetition")
    assert (back.poses[list(extra)] == pd.Series(extra)).all(axis=None)


@IN_ONE_FOLDER
@given(st.lists(st.integers(0, 8), max_size=12))
def test_a_subset_keeps_each_pose_with_its_points(tmp_path: Path, rows: list[int]) -> None:
    """A subset has the requested poses in acquisition order, each with its own points."""
    whole = write_and_read(tmp_path, description(), **tables())
    part = whole.subset(np.array(rows, dtype=int))
    assert part.pose_ids.tolist() == whole.pose_ids[sorted(rows)].tolist()
    for i, row in enumerate(sorted(rows)):
        mine = part.points[part.starts[i] : part.starts[i + 1]]
        assert np.array_equal(mine, whole.points[whole.starts[row] : whole.starts[row + 1]])
    mask = np.isin(np.arange(9), rows)
    assert np.array_equal(whole.subset(mask).q, whole.q[mask])


def test_standard_dh_puts_the_flange_where_its_own_formula_does(tmp_path: Path) -> None:
    """The flange of the converted chain is that of Rz(q + theta) Tz(d) Tx(a) Rx(alpha), multiplied out here."""
    mapping = description()
    mapping["robot"]["convention"] = "standard-dh"
    back = write_and_read(tmp_path, mapping, **tables())
    for i, q in enumerate(back.q):
        T = np.eye(4)
        for angle, joint in zip(q, mapping["robot"]["joints"], strict=True):
            c, s = np.cos(angle + joint["theta"]), np.sin(angle + joint["theta"])
            ca, sa = np.cos(joint["alpha"]), np.sin(joint["alpha"])
            a, d = joint["a"], joint["d"]
            T = T @ [[c, -s * ca, s * sa, a * c], [s, c * ca, -c * sa, a * s], [0, sa, ca, d], [0, 0, 0, 1]]
        flange = back.robot.frames(back.q)[i, -1] @ back.robot.T_n_flange
        assert np.allclose(flange, T, rtol=0.0, atol=1e-14)


def test_harmless_habits_of_other_programs_are_accepted(tmp_path: Path) -> None:
    """Blanks after commas, quotes, Windows line ends, blank lines, byte order marks, +1.5, and 3.0 for an id are read."""
    write_dataset(tmp_path / "d", mapping=description(), **tables())
    plain = read_dataset(tmp_path / "d")
    edit_cell(tmp_path / "d", "scans.csv", 3, "x", f"+{abs(plain.points[1, 0]):.17g}")
    edit_cell(tmp_path / "d", "scans.csv", 3, "pose", "10.0")
    edit_lines(tmp_path / "d", "scans.csv", lambda lines: [*lines[:5], "", *lines[5:], "  "])
    edit_lines(tmp_path / "d", "poses.csv", lambda lines: [line.replace(",", ", ") for line in lines])
    edit_cell(tmp_path / "d", "poses.csv", 4, " plane", '"wall_y"')
    for name in ("scans.csv", "poses.csv"):
        raw = (tmp_path / "d" / name).read_bytes()
        (tmp_path / "d" / name).write_bytes(b"\xef\xbb\xbf" + raw.replace(b"\n", b"\r\n"))
    back = read_dataset(tmp_path / "d")
    assert np.array_equal(np.abs(back.points), np.abs(plain.points))
    assert np.array_equal(back.q, plain.q)
    assert np.array_equal(back.plane_index, plain.plane_index)


def test_only_a_dataset_is_overwritten(tmp_path: Path) -> None:
    """A dataset may be replaced whole; a folder with anything else in it stays untouched."""
    write_dataset(tmp_path / "d", mapping=description(), **tables())
    write_dataset(tmp_path / "d", mapping=description("probe"), **tables("probe"))
    assert validate_dataset(tmp_path / "d") == []
    assert not (tmp_path / "d" / "scans.csv").exists()
    (tmp_path / "d" / "notes.txt").write_text("precious")
    with pytest.raises(InvalidInput, match="already there"):
        write_dataset(tmp_path / "d", mapping=description(), **tables())
    assert validate_dataset(tmp_path / "d") == []
    assert sorted(item.name for item in tmp_path.iterdir()) == ["d"]


def test_a_number_that_is_not_finite_is_not_written(tmp_path: Path) -> None:
    """No folder is written if its content could not be read back."""
    content = tables()
    content["scans"].loc[3, "x"] = np.nan
    with pytest.raises(ValueError, match="not finite"):
        write_dataset(tmp_path / "d", mapping=description(), **content)
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_holds_the_dataset_is_told_from_it(tmp_path: Path) -> None:
    """`scalar simulate -o sim` writes sim/dataset; whoever gives `sim` is told so, once, and nothing else of the folder is called missing."""
    mapping = description()
    write_dataset(tmp_path / "sim" / "dataset", mapping=mapping, **tables())
    (tmp_path / "sim" / "truth").mkdir()
    with pytest.raises(InvalidInput) as refused:
        read_dataset(tmp_path / "sim")
    assert [fault.message for fault in refused.value.faults] == [
        f"the file is missing here, and is in a folder inside; give {str(tmp_path / 'sim' / 'dataset')!r}"
    ]
