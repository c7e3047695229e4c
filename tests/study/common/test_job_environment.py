"""Jobs import the checkout, whatever else is installed, and calculate with one thread."""

import os
import subprocess
import sys

from study.common.job_environment import job_environment


def test_the_checkout_comes_before_what_was_there(tmp_path):
    """Python searches modules in the checkout first, then in the folders that PYTHONPATH had, and nowhere else."""
    now = {**os.environ, "PYTHONPATH": str(tmp_path / "before")}
    environment = job_environment([tmp_path / "one", tmp_path / "two"], now)
    program = "import sys; print(*sys.path[1:4], sep='\\n')"
    started = subprocess.run(
        [sys.executable, "-c", program], env=now | environment, capture_output=True, text=True, check=True
    )
    assert started.stdout.split() == [str(tmp_path / name) for name in ("one", "two", "before")]
    # An empty entry would mean the working directory.
    assert job_environment([tmp_path], {})["PYTHONPATH"] == str(tmp_path)


def test_every_library_gets_one_thread():
    """The numbers of threads that the environment had before are replaced."""
    found = job_environment([], {"OMP_NUM_THREADS": "8"})
    threads = {name: value for name, value in found.items() if name.endswith("_NUM_THREADS")}
    assert threads["OMP_NUM_THREADS"] == threads["OPENBLAS_NUM_THREADS"] == "1"
    assert set(threads.values()) == {"1"}
