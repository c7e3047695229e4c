"""Read profiles in the files that the software of line scanners writes; each file becomes a table of points.

Two layouts need a reader of their own: OpenCV's YAML with one list ``scan_line: [x, y, z, x, ...]``, as the FANUC line scanner profiles of
GilbertPan97/RobCalibrator have it, and the sectioned CSV of LMI's Gocator (Gocator Line Profile Sensors, User Manual, CSV Converter Tool).
Profiles that are saved as plain columns of x and z, one file for each profile (Keyence LJ-V7000, Micro-Epsilon scanCONTROL), are read as text;
the column ``@file_number`` says which pose a file belongs to.
"""

from __future__ import annotations

import csv
import re
from io import StringIO

import numpy as np

from scalar.data.located_table import NUMBER, shorten
from scalar.errors import Fault, InvalidInput
from scalar.geometry.se3 import Array
from scalar.ingest.raw_table import RawTable

_LIST = re.compile(r"^scan_line:\s*\[(.*?)\]", re.DOTALL | re.MULTILINE)
_UNIFORM, _RAW = "Profile", "RawProfile"
_END = "End"


def is_opencv(raw: bytes) -> bool:
    """Return whether a YAML file has the list of a profile, or is what OpenCV writes."""
    return raw.startswith(b"%YAML:1.0") or _LIST.search(raw.decode("utf-8", "replace")) is not None


def read_opencv(file: str, raw: bytes) -> RawTable:
    """Return the points of OpenCV's YAML: columns x, y and z, one row for each point; rows are numbered from 1.

    Raises:
        InvalidInput: it has no list ``scan_line`` of triples of numbers.
    """
    found = _LIST.search(raw.decode("utf-8", "replace"))
    if found is None:
        raise InvalidInput(
            Fault(file, "no list 'scan_line: [x, y, z, ...]', as OpenCV writes a profile; give a CSV file")
        )
    words = [word.strip() for word in found.group(1).split(",") if word.strip()]
    wrong = [k for k, word in enumerate(words) if not NUMBER.fullmatch(word) and word.lower() != ".nan"]
    if wrong or not words or len(words) % 3:
        what = (
            f"number {wrong[0] + 1} of scan_line is {shorten(words[wrong[0]])}"
            if wrong
            else f"{len(words)} numbers"
        )
        raise InvalidInput(
            Fault(file, f"{what}; triples x, y, z are expected, .Nan where nothing was measured")
        )
    values = np.array([np.nan if word.lower() == ".nan" else float(word) for word in words]).reshape(-1, 3)
    return RawTable(file, ("x", "y", "z"), tuple(values.T.copy()), np.arange(1, len(values) + 1))


def is_gocator(raw: bytes) -> bool:
    """Return whether a CSV file has the sections of a Gocator's recording."""
    lines = [line.strip() for line in raw[:2000].decode("utf-8-sig", "replace").splitlines()[:3]]
    return len(lines) > 1 and lines[0].rstrip(",") == "Info" and lines[1].startswith("CSV Version")


def read_gocator(file: str, raw: bytes) -> RawTable:
    """Return the profiles of a Gocator's recording: columns frame, x and z, one row for each point, which has the number of its frame's line of z.

    Evenly spaced profiles have the values of x in the header of their columns; others have a row of x and a row of z for each frame.

    Raises:
        InvalidInput: it holds no profiles, or they are damaged.
    """
    rows = list(csv.reader(StringIO(raw.decode("utf-8-sig", "replace"), newline="")))
    for section in (_UNIFORM, _RAW):
        start = next((i for i, cells in enumerate(rows) if cells and cells[0].strip() == section), None)
        if start is not None:
            break
    else:
        raise InvalidInput(
            Fault(file, f"no section {_UNIFORM} or {_RAW}; export profiles, not surfaces or images")
        )
    end = next((i for i in range(start, len(rows)) if rows[i] and rows[i][0].strip() == _END), len(rows))
    header = next((i for i in range(start + 1, end) if rows[i] and rows[i][0].strip() == "Frame"), None)
    if header is None:
        raise InvalidInput(
            Fault(
                file, f"the section {section} has no row that begins with Frame; export it again", start + 1
            )
        )
    names = [cell.strip() for cell in rows[header]]
    data = [k for k, name in enumerate(names) if NUMBER.fullmatch(name)]
    axis = names.index("Axis") if "Axis" in names else None
    frames: dict[int, dict[str, tuple[int, Array]]] = {}
    for i in range(header + 1, end):
        cells = [cell.strip() for cell in rows[i]]
        if not any(cells):
            continue
        if len(cells) < len(names) or not NUMBER.fullmatch(cells[0]):
            raise InvalidInput(
                Fault(file, f"{len(cells)} cells where {len(names)} are expected; export it again", i + 1)
            )
        values = np.array([float(cells[k]) if NUMBER.fullmatch(cells[k]) else np.nan for k in data])
        frames.setdefault(int(float(cells[0])), {})[cells[axis] if axis is not None else "Z"] = (
            i + 1,
            values,
        )
    parts = []
    for frame, axes in frames.items():
        if "Z" not in axes or (section == _RAW and "X" not in axes):
            raise InvalidInput(
                Fault(file, f"frame {frame} has no row of {'X' if 'Z' in axes else 'Z'}; export it again")
            )
        line, z = axes["Z"]
        x = axes["X"][1] if section == _RAW else np.array([float(names[k]) for k in data])
        parts.append(np.column_stack([np.full(len(z), frame), x, z, np.full(len(z), line)]))
    if not parts:
        raise InvalidInput(Fault(file, f"the section {section} has no frames; record some", header + 1))
    table = np.concatenate(parts)
    return RawTable(file, ("frame", "x", "z"), tuple(table[:, :3].T.copy()), table[:, 3].astype(np.int64))
