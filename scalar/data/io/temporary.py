"""Hidden names for unfinished outputs, and the removal of what killed runs have left under such names.

A name holds the machine and the process that gave it: ``.calibration.json.1f0c3a.4711.9be0c2d1.tmp``. If that process belongs to this
machine and no longer lives, the file is removed when its folder is next written to. A folder that was moved aside (``.old``), so that a
new one could take its place, gets its name back if no new one has it.
"""

from __future__ import annotations

import hashlib
import os
import platform
import re
import secrets
import shutil
from pathlib import Path

from scalar.data.io.processes import lives
from scalar.errors import Fault, InvalidInput

_MACHINE = hashlib.sha256(platform.node().encode(errors="surrogateescape")).hexdigest()[:6]
_NAME = re.compile(
    r"\.(?P<name>.+)\.(?P<machine>[0-9a-f]{6})\.(?P<pid>[0-9]{1,10})\.[0-9a-f]{8}\.(?P<use>tmp|old)",
    re.DOTALL,
)
_swept: set[str] = set()


def temporary_beside(path: Path, use: str = "tmp") -> Path:
    """Return a hidden name in the folder of `path` that nobody else uses.

    Args:
        path: Path of the output.
        use: ``tmp`` for what becomes the output, ``old`` for an output that was moved aside.

    Raises:
        InvalidInput: `path` has no name of its own (``.``, ``..``, ``/``, or nothing at all), or a null character.
    """
    if path.name in ("", "..") or "\0" in str(path):
        raise InvalidInput(Fault(str(path), "no name for an output; give it one, as in out/result"))
    return path.with_name(f".{path.name}.{_MACHINE}.{os.getpid()}.{secrets.token_hex(4)}.{use}")


def sweep_once(folder: Path) -> None:
    """Remove what killed runs have left in a folder, at the first call for it in this process."""
    place = os.path.abspath(folder)
    if place not in _swept:
        _swept.add(place)
        sweep(folder)


def sweep(folder: Path) -> None:
    """Remove the temporary files and folders in a folder whose processes, of this machine, no longer live.

    A folder that was moved aside is given its name back if nothing has that name. What cannot be removed stays.
    """
    try:
        names = os.listdir(folder)
    except OSError:  # missing or not readable: writing there will report it
        return
    for name in names:
        found = _NAME.fullmatch(name)
        if found is None or found["machine"] != _MACHINE or lives(int(found["pid"])):
            continue
        left, output = folder / name, folder / found["name"]
        try:
            if found["use"] == "old" and not output.exists():
                left.rename(output)
            elif left.is_dir() and not left.is_symlink():
                shutil.rmtree(left, ignore_errors=True)
            else:
                left.unlink(missing_ok=True)
        except OSError:
            continue
