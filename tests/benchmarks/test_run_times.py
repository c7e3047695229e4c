"""The table of a run's times: a job counts once, however many files it made, and the seconds of the rules are those of the jobs."""

import re

import pytest

from benchmarks.run_times import frozen_rules, jobs_of, table
from tests.checkouts import ROOT

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
    lines = table(jobs_of([FIRST, SECOND, OTHER]), {"sweep": 1, "draw": 2}, cores=2).splitlines()
    assert [line.split()[0] for line in lines[1:4]] == ["sweep", "draw", "frozen"]
    assert "35 % of the cores' time was without a job" in lines[-1]


def test_what_was_added_to_the_run_later_has_a_sum_of_its_own():
    """Of 26 s, the frozen rule has 8, in two jobs where it had three; the sweep is not in the list, and a rule of the list was not run."""
    lines = table(jobs_of([FIRST, SECOND, OTHER]), {"draw": 3, "paper": 1}, cores=2).splitlines()
    cells = {" ".join(line[:36].split()): line[36:].split() for line in lines[1:] if line}
    assert cells["frozen"] == ["2", "3", "8.0", "4.0"]
    assert cells["added later"] == cells["sweep"] == ["1", "0", "18.0", "18.0"]
    assert cells["all"][:3] == ["3", "3", "26.0"]
    assert "frozen rules that were not run here: paper" in lines
    assert "frozen rules with another number of jobs: draw (2 of 3)" in lines
    assert "that of the frozen rules 4.0 s" in lines[-1]


def test_every_frozen_rule_is_still_a_rule_of_the_workflow():
    """The list names rules by their present names: one that is renamed without its line here would count as added later."""
    rules = {
        found[1]
        for path in (ROOT / "workflow/rules").glob("*.smk")
        for found in re.finditer(
            r"^(?:use )?rule (?:\w+ as )?(\w+)", path.read_text(encoding="utf-8"), re.MULTILINE
        )
    }
    frozen = frozen_rules()
    assert set(frozen) <= rules and all(count > 0 for count in frozen.values())
