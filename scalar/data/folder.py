"""Read a dataset folder and find all its faults, in the list of its files and in their content."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from scalar.data.description import DESCRIPTION, Description, check_description
from scalar.data.io.csv_reader import read_csv
from scalar.data.io.parquet_reader import read_parquet
from scalar.data.io.plain_yaml import load_yaml_lines
from scalar.data.located_table import MISSING_COLUMN, SEPARATED, Table, did_you_mean
from scalar.data.point_units import advice_on_points
from scalar.data.references import check_references, references_layout
from scalar.data.sensor_formats import MeasuredTable, sensor_formats
from scalar.data.table_consistency import (
    check_items,
    check_optional_columns,
    check_points,
    check_poses,
    points_layout,
    poses_layout,
    unknown_data_files,
)
from scalar.data.unit_suspicions import (
    UNIT_DOUBTS,
    suspect_description,
    suspect_joint_angles,
    suspect_points,
)
from scalar.errors import Fault, InvalidInput

POSES = "poses.csv"


def known_files() -> tuple[str, ...]:
    """Return the names of all files that a dataset may have, whatever its sensor."""
    formats = sensor_formats().values()
    tables = [table for format in formats for table in (format.table, format.references)]
    return (DESCRIPTION, POSES, *(file for table in tables if table is not None for file in table.files))


@dataclass(frozen=True)
class Content:
    """What a dataset folder without a fault holds.

    Attributes:
        mapping: the content of dataset.yaml.
        poses: the table of poses, rows as in the file.
        points: the table of the measurements; None for a sensor without such a table.
        references: the table of points fixed to the base; None if the folder has none.
    """

    mapping: dict[str, Any]
    poses: Table
    points: Table | None
    references: Table | None = None


RESULTS = ("calibration.json", "diagnosis.json", "after.json")
"""Files by which a folder is known to be the output of a calibration or a diagnosis."""


def examine_folder(path: Path, faults: list[Fault]) -> Content | None:
    """Return the content of a dataset folder, or None if `faults` is not empty afterwards; every fault found is added to it."""
    names = _list_folder(path, faults)
    if names is None:
        return None
    if DESCRIPTION not in names and (elsewhere := _elsewhere(path, names)):
        faults.append(elsewhere)
        return None
    description = Description(None, {})
    if DESCRIPTION in names:
        try:
            description = Description(*load_yaml_lines(path / DESCRIPTION))
            check_description(description)
            suspect_description(description)
        except InvalidInput as error:
            description.faults += error.faults
        faults += description.faults
    else:
        faults.append(_missing(DESCRIPTION, names))
    poses = points = None
    if POSES in names:
        poses = read_csv(path / POSES, poses_layout(description), faults)
    else:
        faults.append(_missing(POSES, names))
    if poses is not None:
        check_poses(poses, description, faults)
        suspect_joint_angles(poses, description, faults)
    kind = description.kind
    if kind is not None:
        faults += unknown_data_files(kind, names, version_2=description.is_version_2)
    table = None if description.sensor_format is None else description.sensor_format.table
    if kind is not None and table is not None:
        points = _read_points(path, description, table, names, faults)
        if points is not None:
            check_points(points, poses, table, faults)
            suspect_points(points, table, faults, advice_on_points(points, poses, description, table))
    references = _read_references(path, description, poses, names, faults)
    _mention_import(faults)
    if faults or poses is None:
        return None
    return Content(description.mapping, poses, points, references)


def read_folder(path: Path) -> Content:
    """Return the content of a dataset folder.

    Raises:
        InvalidInput: with all the faults found, each with its file, row and column.
    """
    faults: list[Fault] = []
    content = examine_folder(path, faults)
    if content is None:
        raise InvalidInput(faults)
    return content


def _mention_import(faults: list[Fault]) -> None:
    """Add to the first fault of each table that has other columns, separators or units that such a table can be imported as it is."""
    files: set[str] = set()
    for i, fault in enumerate(faults):
        others = fault.message.startswith((SEPARATED, MISSING_COLUMN)) or (
            fault.file != DESCRIPTION and any(doubt in fault.message for doubt in UNIT_DOUBTS)
        )
        if others and fault.file not in files:
            files.add(fault.file)
            message = f"{fault.message}; or import the table as it is by a mapping: `scalar import --help`"
            faults[i] = replace(fault, message=message)


def _list_folder(path: Path, faults: list[Fault]) -> list[str] | None:
    """Return the names of the entries of a folder; None, with a fault, if it cannot be listed or is empty."""
    advice = f"give the folder that holds {DESCRIPTION} and {POSES}"
    try:
        if path.is_file():
            probably = f" ({str(path.parent)!r}?)" if path.name in known_files() else ""
            faults.append(Fault(str(path), f"a file, not a folder; {advice}{probably}"))
            return None
        names = sorted(item.name for item in path.iterdir())
    except FileNotFoundError:
        faults.append(Fault(str(path), f"no such folder; {advice}"))
        return None
    except OSError as error:
        faults.append(Fault(str(path), f"cannot be read ({error.strerror or error}); {advice}"))
        return None
    except ValueError as error:  # a null byte in the path
        faults.append(Fault(str(path), f"not a path ({error}); {advice}"))
        return None
    if not names:
        faults.append(Fault(str(path), f"the folder is empty; {advice}"))
        return None
    return names


def _elsewhere(path: Path, names: list[str]) -> Fault | None:
    """Return the fault of a folder that holds results, or of one in which one folder holds a dataset; None if it is neither."""
    inside = [name for name in names if (path / name / DESCRIPTION).is_file()]
    results = [name for name in RESULTS if name in names]
    if results and not inside and POSES not in names:
        message = f"this folder holds results ({', '.join(results)}); give the folder with what was measured, which holds {DESCRIPTION} and {POSES}"
        return Fault(str(path), message)
    if len(inside) != 1:
        return None
    message = f"the file is missing here, and is in a folder inside; give {str(path / inside[0])!r}"
    return Fault(DESCRIPTION, message)


def _missing(file: str, names: list[str]) -> Fault:
    """Return the fault of a missing file; of the folder's files `names`, one with a similar name is suggested."""
    others = [name for name in names if name not in known_files()]
    hint = did_you_mean(file, others).replace("did you mean", "is it").replace("? ", "? rename it; ")
    return Fault(file, f"the file is missing; {hint}a dataset needs {DESCRIPTION} and {POSES}")


def _one_of_two(files: list[str]) -> Fault:
    """Return the fault of two files of the same table."""
    return Fault(files[1], f"{files[0]} is there too, and only one can be meant; remove one of them")


def _read_references(
    path: Path, description: Description, poses: Table | None, names: list[str], faults: list[Fault]
) -> Table | None:
    """Return the table of points fixed to the base; None if the sensor or the version of the format has no such table, or none can be read."""
    table_format = None if description.sensor_format is None else description.sensor_format.references
    if table_format is None or not description.is_version_2:
        return None
    files = [name for name in table_format.files if name in names]
    if not files:
        return None
    if len(files) > 1:
        faults.append(_one_of_two(files))
        return None
    read = read_parquet if files[0].endswith(".parquet") else read_csv
    table = read(path / files[0], references_layout(table_format), faults)
    if table is not None:
        check_items(table, str(table_format.item), faults)
        check_optional_columns(table, table_format, faults)
        check_references(table, table_format, poses, faults)
        suspect_points(table, table_format, faults)
    return table


def _read_points(
    path: Path, description: Description, table_format: MeasuredTable, names: list[str], faults: list[Fault]
) -> Table | None:
    """Return the table of the measurements; None, with a fault, unless the folder has exactly one and it can be read."""
    files = [name for name in table_format.files if name in names]
    if len(files) > 1:
        faults.append(_one_of_two(files))
        return None
    if not files:
        units = ",".join(dict.fromkeys(table_format.units.values()))
        message = (
            f"the file is missing; a {description.kind} needs {' or '.join(table_format.files)} with the columns "
            f"{','.join(table_format.columns)} [{units}]"
        )
        faults.append(Fault(table_format.files[0], message))
        return None
    read = read_parquet if files[0].endswith(".parquet") else read_csv
    layout = points_layout(table_format, description)
    table = read(path / files[0], layout, faults)
    if table is not None:
        # Unknown columns are already reported; without them the table causes no further faults.
        known = {*layout.required, *layout.optional}
        table.columns = {name: values for name, values in table.columns.items() if name in known}
    return table
