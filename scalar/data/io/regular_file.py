"""Read regular files of limited size, and replace only such; pipes, devices and folders are refused.

Reading a pipe could wait for ever, and a device may deliver bytes without end. Every reader of this package gets its bytes here,
or has the file checked here before a library opens it. A file longer than its limit is refused before it is read. An output appears by
rename, which would remove a pipe or a device of that name.
"""

import os
import stat
from pathlib import Path

from scalar.errors import Fault, InvalidInput

MAX_TABLE_BYTES = 1_000_000_000
"""Largest size of a table [bytes], some 20 million points: a larger one would not fit into the memory of a common computer."""
MAX_JSON_BYTES = 100_000_000
"""Largest size of a JSON file [bytes], enough for the covariance of two thousand parameters."""
_DEVICES = ("/dev", "/proc")


def check_regular_file(path: Path, max_bytes: int, file: str | None = None) -> None:
    """Refuse a path that leads to no regular file, or to one longer than `max_bytes`.

    Args:
        path: path of the file; links are followed.
        max_bytes: the largest size that is accepted [bytes].
        file: what messages call the file; if None, its name.

    Raises:
        InvalidInput: the file is missing, cannot be read, is a pipe, a device, a socket or a folder, or is too long.
    """
    _read(path, max_bytes, file, content=False)


def read_regular_file(path: Path, max_bytes: int, file: str | None = None) -> bytes:
    """Return the bytes of a regular file; arguments and refusals as for `check_regular_file`."""
    return _read(path, max_bytes, file, content=True)


def refuse_special(path: Path) -> None:
    """Refuse a place for an output at which something else than a regular file is, also at the end of a link.

    Links among the system's devices, such as ``/dev/stdout``, are refused even if they lead to a regular file, because a rename replaces the link.

    Raises:
        InvalidInput: There is a folder, a pipe, a socket or a device, or such a link.
    """
    try:
        mode = os.stat(path).st_mode
    except (
        OSError,
        ValueError,
    ):  # nothing is there, or the place cannot be written, which is reported where it is
        return
    of_system = path.is_symlink() and any(map(path.absolute().is_relative_to, _DEVICES))
    if stat.S_ISREG(mode) and not of_system:
        return
    what = (
        "a folder of that name is there"
        if stat.S_ISDIR(mode)
        else "it is a pipe, a device or a socket, not a file"
    )
    raise InvalidInput(Fault(str(path), f"cannot be written ({what}); give another place for the output"))


def path_inside(folder: Path, name: str, file: str, key: str) -> Path:
    """Return the path of a file that another file in a folder names; refuse a path that leads out of the folder, by ``..`` or by a link.

    Args:
        folder: The folder that has to contain both.
        name: The path as it is written, relative to the folder.
        file: What messages call the file in which it is written.
        key: The key or column there.

    Raises:
        InvalidInput: The path leads elsewhere, or is not a path.
    """
    try:
        path = folder / name
        if path.resolve().is_relative_to(folder.resolve()):
            return path
    except (OSError, RuntimeError, ValueError):  # too long a name, a circle of links, a null character
        pass
    message = (
        "leads out of the folder of this file; copy the named file into that folder, and write its name alone"
    )
    raise InvalidInput(Fault(file, message, column=key))


def _read(path: Path, max_bytes: int, file: str | None, *, content: bool) -> bytes:
    """Return the bytes of a regular file, or none without ``content``; arguments and refusals as for `check_regular_file`."""
    file = file or path.name or str(path)
    try:
        _check(os.stat(path), max_bytes, file)  # a device is not even opened: that may already have an effect
        descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
        with os.fdopen(descriptor, "rb") as stream:
            status = os.fstat(descriptor)
            _check(status, max_bytes, file)
            raw = stream.read(status.st_size + 1) if content else b""
            if len(raw) > status.st_size:  # it grows, or the system does not know its size
                raw += stream.read(max(max_bytes + 1 - len(raw), 0))
    except OSError as error:
        reason = "no such file" if isinstance(error, FileNotFoundError) else error.strerror or str(error)
        message = f"cannot be read ({reason}); check the path {str(path)!r} and its permissions"
        raise InvalidInput(Fault(file, message)) from error
    except ValueError as error:  # a null character in the path
        raise InvalidInput(Fault(file, f"not a path ({error}); correct it")) from error
    if len(raw) > max_bytes:
        raise InvalidInput(_too_long(file, max_bytes))
    return raw


def _check(status: os.stat_result, max_bytes: int, file: str) -> None:
    """Refuse what is no regular file, or is longer than `max_bytes`, by its status."""
    if stat.S_ISDIR(status.st_mode):
        raise InvalidInput(Fault(file, "cannot be read (Is a directory); give a file"))
    if not stat.S_ISREG(status.st_mode):
        message = (
            "not a regular file but a pipe, a device or a socket; save its content as a file, and give that"
        )
        raise InvalidInput(Fault(file, message))
    if status.st_size > max_bytes:
        raise InvalidInput(_too_long(file, max_bytes))


def _too_long(file: str, max_bytes: int) -> Fault:
    return Fault(
        file,
        f"longer than {max_bytes // 1_000_000} MB, the most that is read of such a file; make it shorter",
    )
