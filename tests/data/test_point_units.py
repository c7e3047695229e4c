"""Points of a tracker in another unit are recognised by how far they scatter."""

import pandas as pd
import pytest

from scalar.data.dataset import read_dataset
from scalar.errors import InvalidInput
from tests.random_scene import make_scene

AXES = ["x", "y", "z"]


@pytest.mark.parametrize(("size", "name"), [(1e-3, "millimetres"), (1e-2, "centimetres"), (0.0254, "inches")])
def test_the_unit_is_named_in_which_points_are_written(size, name, tmp_path):
    """Each column that cannot be metres is one fault, with the unit in which the flange's nominal places scatter as the points do."""
    folder = make_scene("vs060", "tracker", seed=2, poses_per_plane=20).write(tmp_path / "cell")
    table = pd.read_csv(folder / "points.csv")
    table[AXES] = (table[AXES] + 3.0) / size  # the tracker stands a few metres away
    table["x"] += 250.0  # farther away than any tracker, in whatever unit that is
    table.to_csv(folder / "points.csv", index=False)
    with pytest.raises(InvalidInput) as refused:
        read_dataset(folder)
    named = {fault.column: fault.message for fault in refused.value.faults}
    assert set(named) >= {"x"} and set(named) <= set(AXES)
    assert all(f"are these {name}? write metres" in message for message in named.values())


def test_where_the_angles_are_at_fault_as_well_no_other_unit_is_claimed(tmp_path):
    """Without joint angles nothing is known of the scatter: millimetres, the usual unit, are asked for."""
    folder = make_scene("vs060", "tracker", seed=2, poses_per_plane=20).write(tmp_path / "cell")
    points = pd.read_csv(folder / "points.csv")
    points[AXES] = (points[AXES] + 3.0) * 100.0
    points.to_csv(folder / "points.csv", index=False)
    poses = pd.read_csv(folder / "poses.csv").astype({"q2": object})
    poses.loc[3, "q2"] = "north"
    poses.to_csv(folder / "poses.csv", index=False)
    with pytest.raises(InvalidInput) as refused:
        read_dataset(folder)
    said = [fault.message for fault in refused.value.faults if fault.file == "points.csv"]
    assert said and all("are these millimetres?" in message for message in said)


@pytest.mark.parametrize("damage", ["no column", "a number beyond measure"])
def test_a_damaged_table_is_refused_for_its_damage(damage, tmp_path):
    """A table without x, or with a number whose square overflows, is refused for that, whatever else looks like another unit."""
    folder = make_scene("vs060", "tracker", seed=2, poses_per_plane=20).write(tmp_path / "cell")
    points = pd.read_csv(folder / "points.csv")
    points[AXES] = (points[AXES] + 3.0) * 100.0
    if damage == "no column":
        points = points.drop(columns="x")
    else:
        points.loc[2, "x"] = 1e200
    points.to_csv(folder / "points.csv", index=False)
    with pytest.raises(InvalidInput) as refused:
        read_dataset(folder)
    assert any(fault.column == "x" and "suspect" not in fault.message for fault in refused.value.faults)


@pytest.mark.parametrize(
    ("size", "words"), [(1e-3, "are these millimetres? write"), (1e-2, "millimetres or centimetres?")]
)
def test_a_scan_that_may_be_in_centimetres_is_asked_about_both(size, words, tmp_path):
    """Numbers below 50 may be centimetres of a scanner as well as millimetres of one that measures from very near."""
    folder = make_scene("vs060", seed=2, poses_per_plane=8).write(tmp_path / "cell")
    scans = pd.read_csv(folder / "scans.csv")
    scans[["x", "z"]] /= size
    scans.to_csv(folder / "scans.csv", index=False)
    with pytest.raises(InvalidInput) as refused:
        read_dataset(folder)
    said = [fault.message for fault in refused.value.faults if fault.column == "z"]
    assert said and all(words in message for message in said)


def test_where_the_unit_changes_within_a_column_its_rows_are_named(tmp_path):
    """All numbers between the first and the last row that cannot be metres are millimetres, those that could be metres too."""
    folder = make_scene("vs060", "tracker", seed=2, poses_per_plane=20).write(tmp_path / "cell")
    table = pd.read_csv(folder / "points.csv")
    table["x"] = 2.0
    table.loc[24:48, "x"] = 2000.0
    table.loc[30, "x"] = 150.0
    table.to_csv(folder / "points.csv", index=False)
    with pytest.raises(InvalidInput) as refused:
        read_dataset(folder)
    (said,) = [fault.message for fault in refused.value.faults if fault.column == "x"]
    assert "24 of 60 numbers, in rows 26 to 50, are beyond" in said
