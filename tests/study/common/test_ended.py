"""A workflow that is asked to end does so, also in a moment in which its scheduler holds its lock."""

import subprocess
import sys

from snakemake.scheduling.job_scheduler import JobScheduler

from tests.checkouts import ROOT

ASKED_WHILE_LOCKED = """
import os, signal, sys, threading
from snakemake.scheduling.job_scheduler import JobScheduler
from study.common.ended import end_when_asked

scheduler = object.__new__(JobScheduler)
scheduler._lock, scheduler._open_jobs, scheduler._user_kill = threading.Lock(), threading.Semaphore(0), None
signal.signal(signal.SIGTERM, scheduler.exit_gracefully)  # as Snakemake sets it
if "mended" in sys.argv:
    end_when_asked(scheduler)
with scheduler._lock:
    os.kill(os.getpid(), signal.SIGTERM)
assert scheduler._open_jobs.acquire(timeout=20)
print(scheduler._user_kill)
"""


def test_a_scheduler_that_holds_its_lock_is_asked_to_end():
    """Snakemake's own method runs once the lock is free, and wakes the scheduler.

    Its handler without this waits for ever for a lock that its own thread holds.
    """
    ran = subprocess.run(
        [sys.executable, "-c", ASKED_WHILE_LOCKED, "mended"],
        cwd=ROOT / "workflow",
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert ran.returncode == 0, ran.stderr
    assert ran.stdout.strip() == "graceful"


def test_snakemake_still_has_what_is_called():
    """The handler of the workflow calls this method, which a later Snakemake may have renamed."""
    assert callable(JobScheduler.exit_gracefully)
