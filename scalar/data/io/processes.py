"""Check whether a process lives, and end a process when the one that it works for has ended."""

from __future__ import annotations

import os
import threading
import time

_CHECK_INTERVAL = 0.5  # s


def lives(pid: int) -> bool:
    """Return whether a process of this machine has that number."""
    try:
        os.kill(pid, 0)
    except (ProcessLookupError, OverflowError):
        return False
    except OSError:  # it belongs to another user
        return True
    return True


def end_with(owner: int) -> None:
    """End this process, whatever it does, when the process `owner` has ended, since nobody then uses what it computes.

    Args:
        owner: Number of a process that lives, in general the one that started this one. If no process has this
            number, because the owner is on another machine or outside this container, nothing is watched.
    """
    if lives(owner):
        threading.Thread(target=_watch, args=(owner, os.getppid() == owner), daemon=True).start()


def _watch(owner: int, is_parent: bool) -> None:
    """End this process when the owner has gone; the end of a parent is noticed even if its number stays in use for a while."""
    while os.getppid() == owner if is_parent else lives(owner):
        time.sleep(_CHECK_INTERVAL)
    os._exit(1)
