"""The table of a run's times: a job counts once, however many files it made, and the seconds of the rules are those of the jobs."""

import pytest

from benchmarks.run_times import jobs_of, table

FIRST, SECOND = (
    {"rule": "draw", "log": [f"logs/{k}.log"], "starttime": 10.0 * k, "endtime": 10.0 * k + 4.0}
    for k in (1, 2)
)
OTHER = {"rule": "sweep", "log": ["logs/sweep.log"], "starttime": 12.0, "endtime": 30.0}
UNFINISHED = {"rule": "paper", "log": ["logs/paper.log"], "starttime": 31.0, "endtime": None}


def test_a_job_with_several_outputs_is_one_job():
    """Snakemake writes a record for each output of a job, whose starts differ by rounding.

    They count as one job, and jobs that have not ended are left out.
    """
    again = {**FIRST, "starttime": FIRST["starttime"] + 1e-6}
    jobs = jobs_of([OTHER, FIRST, again, SECOND, UNFINISHED])
    assert [job.rule for job in jobs] == ["draw", "sweep", "draw"]
    assert sum(job.seconds for job in jobs) == pytest.approx(26.0, abs=1e-4)


def test_the_table_states_how_busy_the_cores_were():
    """In 20 s, jobs that take 26 s together keep two cores busy for 65 % of the time."""
    lines = table(jobs_of([FIRST, SECOND, OTHER]), cores=2).splitlines()
    assert [line.split()[0] for line in lines[1:4]] == ["sweep", "draw", "all"]
    assert "35 % of the cores' time was without a job" in lines[-1]
