"""One writer for a folder of results at a time.

The lock is a record lock on a hidden file of the folder; the file holds the number of the process that owns it. The system releases such a
lock when its owner ends, however it ends, so that the next process gets it. On a shared file system without locks, the process number
in the file is checked instead, which keeps out other processes of the same machine only.
"""

from __future__ import annotations

import errno
import fcntl
import os
import platform
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from scalar.data.io.atomic import cannot_write
from scalar.data.io.processes import lives
from scalar.data.io.temporary import sweep
from scalar.errors import Fault, InvalidInput

LOCK = ".scalar.lock"
_HELD_BY_ANOTHER = (errno.EACCES, errno.EAGAIN)
_NO_LOCKS = (errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP, errno.EINVAL)
_held: set[tuple[int, int]] = set()
"""(device, inode) of each lock that this process holds, since record locks do not keep a process from locking twice."""


@contextmanager
def locked(folder: Path) -> Iterator[Path]:
    """Lock a folder of results for this process while the block runs; the folder is made if missing, and removed if it stays empty.

    Temporary files that killed runs have left in it are removed first.

    Raises:
        InvalidInput: The folder cannot be written, or another running process is writing to it.
    """
    new = _missing(folder)
    try:
        if folder.exists() and not folder.is_dir():
            raise NotADirectoryError(None, "something else than a folder is there")
        folder.mkdir(parents=True, exist_ok=True)
        descriptor, at = _acquire(folder)
    except (OSError, ValueError) as error:
        _remove(new)
        raise cannot_write(folder, error) from None
    try:
        sweep(folder)
        yield folder
    finally:
        with suppress(OSError):
            (folder / LOCK).unlink(missing_ok=True)
        os.close(descriptor)
        _held.discard(at)
        _remove(new)


def _missing(folder: Path) -> list[Path]:
    """Return the folders that have to be made, the innermost first."""
    with suppress(OSError, ValueError):
        return [path for path in (folder, *folder.parents) if not path.exists()]
    return []


def _remove(folders: list[Path]) -> None:
    """Remove folders, in order, up to the first that is not empty."""
    with suppress(OSError, ValueError):
        for folder in folders:
            folder.rmdir()


def _acquire(folder: Path) -> tuple[int, tuple[int, int]]:
    """Lock the folder, and return the descriptor of the lock file and its (device, inode)."""
    path = folder / LOCK
    while True:
        with suppress(FileNotFoundError):
            there = path.stat()
            if (there.st_dev, there.st_ino) in _held:
                raise _taken(folder, path)
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC | os.O_NOFOLLOW, 0o644)
        try:
            _lock(descriptor, folder, path)
            mine = os.fstat(descriptor)
            try:
                there = path.stat()
            except FileNotFoundError:  # its last owner removed it meanwhile
                os.close(descriptor)
                continue
            if (there.st_dev, there.st_ino) != (mine.st_dev, mine.st_ino):
                os.close(descriptor)
                continue
            _state_owner(descriptor, path)
        except BaseException:
            with suppress(OSError):
                os.close(descriptor)
            raise
        at = (mine.st_dev, mine.st_ino)
        _held.add(at)
        return descriptor, at


def _state_owner(descriptor: int, path: Path) -> None:
    """Write into a lock file that this process holds who holds it; remove the file if it cannot be written, as on a full disk."""
    try:
        os.ftruncate(descriptor, 0)
        os.pwrite(descriptor, f"{os.getpid()} {platform.node()}\n".encode(errors="replace"), 0)
    except OSError:
        with suppress(OSError):
            path.unlink()
        raise


def _lock(descriptor: int, folder: Path, path: Path) -> None:
    try:
        fcntl.lockf(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        if error.errno in _HELD_BY_ANOTHER:
            raise _taken(folder, path) from None
        if error.errno not in _NO_LOCKS:
            raise
        pid, machine = _owner(path)
        if pid not in (None, os.getpid()) and machine == platform.node() and lives(pid):
            raise _taken(folder, path) from None


def _owner(path: Path) -> tuple[int | None, str]:
    """Return the number of the process that a lock file names, None if it names none, and its machine."""
    with suppress(OSError, ValueError):
        pid, _, machine = path.read_text(errors="replace").strip().partition(" ")
        return int(pid), machine
    return None, ""


def _taken(folder: Path, path: Path) -> InvalidInput:
    pid, machine = _owner(path)
    who = "another process" if pid is None else f"process {pid} on {machine}"
    message = (
        f"{who} is writing to this folder; wait until it has ended, or give another place for the output"
    )
    return InvalidInput(Fault(str(folder), message))
