"""Send what a script of the workflow prints to its log; every script imports this first.

It also keeps each process to one thread of BLAS, before NumPy reads the number: Snakemake sets it to the cores of the job, and a job that takes
several cores starts as many processes.
"""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from traceback import print_exc

from study.common.job_environment import ONE_THREAD
from study.common.take_over import end_with_workflow

os.environ.update(ONE_THREAD)


@contextmanager
def logged(log: list[str]) -> Iterator[None]:
    """Send stdout and stderr, and a failure's traceback, to the rule's log, which Snakemake would leave empty."""
    with (
        open(log[0], "w", encoding="utf-8", buffering=1) as file,
        redirect_stdout(file),
        redirect_stderr(file),
    ):
        end_with_workflow()
        try:
            yield
        except Exception as error:
            print_exc()
            print(f"{log[0]}: {type(error).__name__}: {error}", file=sys.__stderr__)
            sys.exit(1)
