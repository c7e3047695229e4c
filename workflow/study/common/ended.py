"""Let a workflow that is asked to end do so, whatever its scheduler does at that moment."""

from __future__ import annotations

import _thread
import signal
from contextlib import suppress
from typing import Any, Protocol


class Scheduler(Protocol):
    """What is used of Snakemake's scheduler."""

    def exit_gracefully(self, *args: Any) -> None:
        """Start no further job, and end when those that run have ended."""


def end_when_asked(scheduler: Scheduler) -> None:
    """Pass SIGTERM to the scheduler from a thread of its own.

    Snakemake (9.27) takes a lock in the handler itself. If the signal meets the main thread while it holds this lock, which is while it starts or
    finishes jobs, the handler waits for its own thread, and the workflow neither goes on nor ends.

    Args:
        scheduler: Of the workflow that runs. Outside of the main thread, where no handler can be set, nothing is changed.
    """
    with suppress(ValueError):
        # Not `threading.Thread`, which takes a lock that the interrupted thread may hold as well.
        signal.signal(signal.SIGTERM, lambda *_: _thread.start_new_thread(scheduler.exit_gracefully, ()))
