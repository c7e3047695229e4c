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
