"""Whether a process lives, and processes that end with the one that they work for."""

from __future__ import annotations

import os
import threading
import time

_LOOKS = 0.5  # s between looks


def lives(pid: int) -> bool:
    """Return whether a process of this machine has that number."""
    try:
        os.kill(pid, 0)
    except (ProcessLookupError, OverflowError):
        return False
    except OSError:  # of another user
        return True
    return True


def end_with(owner: int) -> None:
    """End this process, whatever it does, when the process `owner` has gone: nothing computes on for nobody.

    Args:
        owner: Number of a process that lives, in general the one that started this one. One that is not there now is not watched: it
            belongs to another machine, or to the outside of a container.
    """
    if lives(owner):
        threading.Thread(target=_watch, args=(owner, os.getppid() == owner), daemon=True).start()


def _watch(owner: int, is_parent: bool) -> None:
    """End this process when the owner has gone; a parent that ended is told at once, though its number may be taken for a while."""
    while os.getppid() == owner if is_parent else lives(owner):
        time.sleep(_LOOKS)
    os._exit(1)
