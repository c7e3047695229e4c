"""A fleet's table lists what was found, and apart from it the names that are not sure."""

import subprocess
import sys

import pytest

from scalar.cli.fleet_table import _line as line_for_terminal
from scalar.diagnosis import diagnose
from scalar.report import diagnosed_workspace, render_report
from scalar.report.fleet_row import row_of, sure_and_unsure
from tests.checkouts import ROOT
from tests.random_scene import make_scene

LEAST = 0.6


def entry(name, confidence, **more):
    """Return an entry of ``effects`` in diagnosis.json."""
    return {"name": name, "target": {"joint": 2}, "confidence": confidence, "confounded_with": [], **more}


SURE, LIKELY = entry("joint_scale", 0.95), entry("joint_harmonic", 0.61)
DOUBTFUL = entry("joint_backlash", 0.51, confounded_with=[{"name": "joint_scale", "target": {"joint": 2}}])
STRUCTURE = entry("unattributed", 0.45, target={}, most_like=[entry("pose_lag", 0.4)])


@pytest.mark.parametrize(
    ("effects", "found", "unsure"),
    [
        ([SURE, DOUBTFUL, LIKELY], [SURE, LIKELY], [DOUBTFUL]),
        ([STRUCTURE], [STRUCTURE], STRUCTURE["most_like"]),
        ([DOUBTFUL], [], [DOUBTFUL]),
        ([], [], []),
    ],
)
def test_a_name_that_is_not_sure_is_not_listed_as_found(effects, found, unsure):
    """Names with less confidence than a diagnosis gives a name alone stand apart; unmodelled structure is found all the same."""
    assert sure_and_unsure(effects, LEAST) == (found, unsure)


def test_the_terminal_says_perhaps():
    """A dataset in which only an unsure name was found is not said to have no effect, nor to have this one."""
    row = {"folder": "a", "status": 0, "held_out_before_mm": 0.2, "held_out_after_mm": 0.1}
    said = line_for_terminal({**row, "effects": "", "unsure_effects": "joint 2: backlash (0.51)"})
    assert "a: perhaps joint 2: backlash (0.51) (0.2000" in said
    assert "no effect found" in line_for_terminal({**row, "effects": "", "unsure_effects": ""})


def test_the_errors_over_the_workspace_are_computed_once_for_row_and_report(monkeypatch):
    """They take a fifth of the time of a small dataset of a fleet, and both state them."""
    computed = []
    errors = diagnosed_workspace.errors_within_limits
    monkeypatch.setattr(
        diagnosed_workspace, "errors_within_limits", lambda *given: computed.append(given) or errors(*given)
    )
    diagnosis = diagnose(make_scene(kind="tracker", poses_per_plane=9).dataset, outer_folds=0)
    row = row_of(diagnosis)
    assert f"{row['after_error_mm']:.3g}" in render_report(diagnosis)
    assert len(computed) == 1
    row_of(diagnose(make_scene(kind="tracker", poses_per_plane=10).dataset, outer_folds=0))
    assert len(computed) == 2  # another diagnosis has errors of its own


FORKED_LATER = """
import sys
from scalar import report
from scalar.diagnosis import diagnose
from tests.checkouts import ROOT
from tests.random_scene import make_scene

diagnosis = diagnose(make_scene(kind="tracker", poses_per_plane=9).dataset, outer_folds=0)
report.prepare()
known = set(sys.modules)
report._environment().loader.get_source = None  # no template is read again
assert "</html>" in report.render_report(diagnosis)
print(sorted(set(sys.modules) - known))
"""


def test_the_report_needs_nothing_more_after_it_was_prepared():
    """Every process of a fleet has all modules and templates from the one that it is forked from."""
    ran = subprocess.run([sys.executable, "-c", FORKED_LATER], cwd=ROOT, capture_output=True, text=True)
    assert ran.returncode == 0, ran.stderr
    assert ran.stdout.strip() == "[]"
