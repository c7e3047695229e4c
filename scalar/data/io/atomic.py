"""Files and folders that appear whole or not at all.

Everything is written under a temporary name in the folder of its destination and renamed when
it is complete. A run that dies half-way leaves at most a hidden temporary file, never half an output; the next one that
writes to the same folder removes it.
Left out: protection against power failure (no fsync).
"""

import errno
import json
import math
import os
import shutil
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from scalar.data.io.regular_file import refuse_special
from scalar.data.io.temporary import sweep_once, temporary_beside
from scalar.errors import Fault, InvalidInput

_NO_ROOM = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
_BROKEN = (*_NO_ROOM, errno.EROFS, errno.EIO, errno.ESTALE)


def cannot_write(path: Path, error: OSError | ValueError) -> InvalidInput:
    """Return the error for a place where the system does not allow writing."""
    number = getattr(error, "errno", None)
    reason = getattr(error, "strerror", None) or str(error)
    room = "make room, or " if number in _NO_ROOM else ""
    return InvalidInput(
        Fault(str(path), f"cannot be written ({reason}); {room}give another place for the output")
    )


@contextmanager
def atomic_write(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Yield a temporary path beside `path`; rename it to `path` on success, remove it on failure.

    Missing parent folders are made. An older file at `path` stays as it is until the new one is complete.

    Raises:
        InvalidInput: the place cannot be written, or holds something that is no regular file, such as a folder or a device.
    """
    path = Path(path)
    temporary = temporary_beside(path)
    try:
        refuse_special(path)
        path.parent.mkdir(parents=True, exist_ok=True)
        sweep_once(path.parent)
        temporary.open("xb").close()
    except OSError as error:
        raise cannot_write(path, error) from error
    try:
        yield temporary
        try:
            temporary.replace(path)
        except OSError as error:
            raise cannot_write(path, error) from error
    except BaseException as error:
        with suppress(OSError):
            temporary.unlink(missing_ok=True)
        if isinstance(error, OSError) and error.errno in _BROKEN:  # the disk is full, or went away
            raise cannot_write(path, error) from error
        raise


def write_together(folder: Path, contents: Mapping[str, str | bytes]) -> None:
    """Write the files of one result to a folder: none is put in its place before all are complete, so that a full disk leaves the older ones.

    Args:
        folder: An existing folder.
        contents: The content of each file by its name, in the order in which they are put in their places.

    Raises:
        InvalidInput: One of them cannot be written.
    """
    with ExitStack() as stack:  # which ends with the file that was begun first
        for name, content in reversed(list(contents.items())):
            temporary = stack.enter_context(atomic_write(folder / name))
            temporary.write_bytes(content.encode() if isinstance(content, str) else content)


@contextmanager
def atomic_directory(
    path: str | os.PathLike[str],
    may_replace: Callable[[Path], bool] = lambda _: False,
    remedy: str = "not an output of this kind; remove it, or give another place",
) -> Iterator[Path]:
    """Yield an empty temporary folder beside `path`; rename it to `path` on success, remove it on failure.

    Args:
        path: the folder that is to appear. Missing parents are made. A link to a folder stays, and what it leads to is replaced.
        may_replace: asked about a folder that is already there and not empty; True lets it be replaced.
        remedy: end of the message about a folder that may not be replaced.

    Raises:
        InvalidInput: the place cannot be written, or holds something that may not be replaced.
    """
    path = Path(path)
    leads_to_folder = path.is_symlink() and path.is_dir()
    place = Path(os.path.realpath(path)) if leads_to_folder else path
    temporary = temporary_beside(place)
    sweep_once(place.parent)
    check_replaceable(path, may_replace, remedy)
    try:
        place.parent.mkdir(parents=True, exist_ok=True)
        temporary.mkdir()
    except OSError as error:
        raise cannot_write(path, error) from error
    try:
        yield temporary
        try:
            _swap_in(temporary, place)
        except OSError as error:
            raise cannot_write(path, error) from error
    except BaseException as error:
        shutil.rmtree(temporary, ignore_errors=True)
        if isinstance(error, OSError) and error.errno in _BROKEN:
            raise cannot_write(path, error) from error
        if isinstance(error, InvalidInput):
            raise InvalidInput(_in_place(fault, temporary, path) for fault in error.faults) from error
        raise


def _in_place(fault: Fault, temporary: Path, path: Path) -> Fault:
    """Return a fault with the name that a file in a temporary folder was to have, instead of one that nobody else knows."""
    return replace(fault, file=fault.file.replace(str(temporary), str(path)))


def check_replaceable(path: Path, may_replace: Callable[[Path], bool], remedy: str) -> None:
    """Refuse a place for a folder that is taken by something that may not be replaced; arguments as for ``atomic_directory``."""
    if path.exists() and not (path.is_dir() and (not any(path.iterdir()) or may_replace(path))):
        raise InvalidInput(Fault(str(path), f"already there, and {remedy}"))


def _swap_in(new: Path, path: Path) -> None:
    """Rename the folder `new` to `path`; what was at `path` is removed, or restored if the renaming fails."""
    if not path.exists():
        new.rename(path)
        return
    old = temporary_beside(path, "old")
    path.rename(old)
    try:
        new.rename(path)
    except BaseException:
        old.rename(path)
        raise
    shutil.rmtree(old, ignore_errors=True)


def plain(value: Any) -> Any:
    """Return `value` in plain Python types: arrays and tuples as lists, NumPy scalars as numbers.

    Raises:
        TypeError: `value` holds something that has no plain form.
    """
    if value is None or isinstance(value, bool | str):
        return value
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist())
    if isinstance(value, int | float):
        return value
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if isinstance(value, dict):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    raise TypeError(f"no plain form for {type(value).__name__}")


def _finite(value: Any) -> Any:
    """Return a plain `value` with None in place of every number that is not finite."""
    if isinstance(value, float) and not math.isfinite(value):
        return None
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_finite(item) for item in value]
    return value


def json_content(obj: Any) -> Any:
    """Return `obj` as it is read back from the file that ``write_json`` writes: plain, with None for numbers that are not finite."""
    return _finite(plain(obj))


def json_text(obj: Any) -> str:
    """Return `obj` as the text of a JSON file: keys in the given order, indent 1, a line end at the end, null for numbers that are not finite."""
    return json.dumps(json_content(obj), indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def write_json(path: str | os.PathLike[str], obj: Any) -> None:
    """Write `obj` to `path` as JSON, atomically: keys in the given order, indent 1, and a line end at the end.

    Numbers that are not finite become null, since JSON has no others; floats read back exactly.
    """
    text = json_text(obj)
    with atomic_write(path) as temporary:
        temporary.write_text(text, encoding="utf-8", newline="\n")
