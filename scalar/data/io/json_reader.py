"""Read SCALAR's JSON files, and refuse damaged ones: plain data with finite numbers, text that can be written, and bounded depth."""

import json
import math
from collections import Counter
from pathlib import Path
from typing import Any

from scalar.data.io.plain_yaml import LARGEST, MAX_DEPTH, has_half_character, join_path
from scalar.data.io.regular_file import MAX_JSON_BYTES, read_regular_file
from scalar.errors import Fault, InvalidInput

_MAX_DIGITS = 400  # no number needs more, and Python refuses to convert integers of several thousand digits


def read_json(path: Path) -> Any:
    """Return the plain data in a JSON file.

    Raises:
        InvalidInput: the file cannot be read, is no JSON or is longer than 100 MB; or, each named by its key, a key stands twice, or a value is
            nested more than 20 deep, is not finite, is too large to compute with, or holds a lone surrogate.
    """
    file = str(path)
    raw = read_regular_file(path, MAX_JSON_BYTES, file)
    faults: list[Fault] = []

    def mapping(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        found = dict(pairs)
        if len(found) < len(pairs):
            times = Counter(name for name, _ in pairs)
            twice = next(name for name, _ in pairs if times[name] > 1)
            faults.append(
                Fault(file, "this key stands twice in one place; remove one of the two", column=twice)
            )
        return found

    try:
        content = json.loads(
            raw.decode("utf-8"),
            parse_int=lambda digits: int(digits) if len(digits) <= _MAX_DIGITS else math.inf,
            object_pairs_hook=mapping,
        )
    except UnicodeDecodeError as error:
        message = f"byte {error.start} is not UTF-8; write the file again"
        raise InvalidInput(Fault(file, message, raw.count(b"\n", 0, error.start) + 1)) from error
    except json.JSONDecodeError as error:
        raise InvalidInput(
            Fault(file, f"not JSON ({error.msg}); write the file again", error.lineno)
        ) from error
    except RecursionError as error:
        raise InvalidInput(Fault(file, f"nested more than {MAX_DEPTH} deep; write the file again")) from error
    _check(content, (), file, faults)
    if faults:
        raise InvalidInput(faults)
    return content


def _check(value: Any, path: tuple[str | int, ...], file: str, faults: list[Fault]) -> None:
    """Add every value that such a file may not hold to `faults`, with its key."""

    def fault(message: str) -> None:
        faults.append(Fault(file, message, column=join_path(path) or None))

    if isinstance(value, dict | list):
        if len(path) >= MAX_DEPTH:
            fault(f"nested more than {MAX_DEPTH} deep; write the file again")
            return
        if isinstance(value, list) and _all_usable(value):
            return
        for key, item in value.items() if isinstance(value, dict) else enumerate(value):
            _check(key, (*path, key), file, faults)
            _check(item, (*path, key), file, faults)
    elif isinstance(value, str):
        if has_half_character(value):
            fault("holds half a character (a lone surrogate); write the text anew")
    elif isinstance(value, int | float) and not abs(value) <= LARGEST:
        fault("not a finite number of at most 1e100; write the number")


def _all_usable(values: list[Any]) -> bool:
    """Return whether a list has only real numbers that may stand in such a file, without a step of Python for each: a covariance has millions."""
    return set(map(type, values)) <= {int, float} and all(-LARGEST <= value <= LARGEST for value in values)
