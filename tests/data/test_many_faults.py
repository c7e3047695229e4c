"""Many faults of one kind: how many lines they are."""

from pathlib import Path

import pandas as pd

from scalar.data.dataset import validate_dataset
from scalar.data.dataset_writer import write_dataset
from scalar.data.located_table import MAX_SHOWN
from tests.small_datasets import description, edit_lines, tables


def test_a_thousand_faults_of_one_kind_are_counted_not_listed(tmp_path: Path) -> None:
    """Faults that differ are listed up to a number, and one more line counts the rest; the same fault in many rows is one line."""
    content = tables()
    content["scans"] = pd.concat([content["scans"]] * 30)
    write_dataset(tmp_path / "d", mapping=description(), **content)
    good = (tmp_path / "d" / "scans.csv").read_text(encoding="utf-8")
    for mark, lines in (("?{}", MAX_SHOWN + 1), ("?", 1)):
        (tmp_path / "d" / "scans.csv").write_text(good, encoding="utf-8")
        edit_lines(
            tmp_path / "d",
            "scans.csv",
            lambda ls, mark=mark: [
                *ls[:2],
                *(f"{x.rsplit(',', 1)[0]},{mark.format(i)}" for i, x in enumerate(ls[2:])),
            ],
        )
        faults = validate_dataset(tmp_path / "d")
        assert len(faults) == lines
        count = 36 * 30 - 1 - (MAX_SHOWN if lines > 1 else 0)
        assert (
            f"{count} more rows" in faults[-1].message
            or f"{count} rows with this fault" in faults[-1].message
        )


def test_poses_that_are_counted_anew_are_one_fault(tmp_path: Path) -> None:
    """If a table was joined of two whose numbers begin alike, one line says so; a few numbers that stand twice are named one by one."""
    write_dataset(tmp_path / "d", mapping=description(), **tables())
    poses = (tmp_path / "d" / "poses.csv").read_text(encoding="utf-8").splitlines()
    for again, lines in ((2 * poses[1:], 1), (poses[1:3], 2)):
        (tmp_path / "d" / "poses.csv").write_text("\n".join([*poses, *again]) + "\n", encoding="utf-8")
        faults = [fault for fault in validate_dataset(tmp_path / "d") if fault.file == "poses.csv"]
        assert len(faults) == lines and faults[0].row == len(poses) + 1
        assert "stands already in row 2" in faults[0].message
