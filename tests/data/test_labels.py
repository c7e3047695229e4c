"""A label that is wrong in many rows is one fault."""

from pathlib import Path

import numpy as np
import pandas as pd

from scalar.data.dataset import validate_dataset
from scalar.data.dataset_writer import write_dataset
from scalar.ingest.imported_table import ImportedTable
from tests.small_datasets import description, tables


def test_a_misspelt_label_is_one_fault_with_its_rows(tmp_path: Path) -> None:
    """Each misspelling is one line, at its first row, with its rows and the name that is nearest."""
    content = tables()
    planes = content["poses"]["plane"].to_numpy(dtype=object)
    wrong = np.where(planes == "floor", "flor", planes)
    one = int(np.flatnonzero(planes == "wall_x")[-1])
    wrong[one] = "wal_x"
    content["poses"]["plane"] = wrong
    write_dataset(tmp_path / "d", mapping=description(), **content)
    faults = validate_dataset(tmp_path / "d")
    rows = np.flatnonzero(planes == "floor") + 2  # as an editor counts them, the header being row 1
    assert {fault.row for fault in faults} == {int(rows[0]), one + 2}
    message = next(fault.message for fault in faults if fault.row == rows[0])
    assert "unknown plane 'flor'; did you mean 'floor'?" in message
    assert message.endswith(f"({len(rows)} rows: {', '.join(map(str, rows))})")
    assert "rows" not in next(fault.message for fault in faults if fault.row == one + 2)


def test_a_target_that_is_no_name_is_one_fault(tmp_path: Path) -> None:
    """So it is with names of targets; of many rows the first three are listed."""
    content = tables("tracker")
    content["points"] = pd.DataFrame({**content["points"], "target": "A 1"})
    write_dataset(tmp_path / "d", mapping={**description("tracker"), "format": "scalar-dataset/2"}, **content)
    (fault,) = validate_dataset(tmp_path / "d")
    assert f"({len(content['points'])} rows: 2, 3, 4, ...)" in fault.message


def test_labels_of_several_files_are_faults_of_each() -> None:
    """Rows are counted in their own file, so the same misspelling in two files is two faults."""
    labels = np.array(["flor", "flor", "flor", "floor"], dtype=object)
    files = np.array(["a.csv", "a.csv", "b.csv", "b.csv"], dtype=object)
    table = ImportedTable(
        "a.csv", {"plane": labels}, lambda: np.array([2, 3, 2, 3]), files=files, labels={"plane": "target"}
    )
    faults = []
    table.report_labels(faults, "plane", labels == "flor", lambda i: f"unknown {labels[i]}")
    said = [(fault.file, fault.row, fault.column, fault.message) for fault in faults]
    assert said == [
        ("a.csv", 2, "target", "unknown flor (2 rows: 2, 3)"),
        ("b.csv", 2, "target", "unknown flor"),
    ]
    table.report(faults, "plane", labels == "flor", lambda _: "again")
    assert len(faults) == 2
