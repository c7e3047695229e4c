"""The report and the lines of the command say why a confidence is no larger, where a rule and not the trials set it."""

from dataclasses import replace

import pytest

from scalar.cli.diagnosis_words import describe_diagnosis
from scalar.report import render_report

RULE = "only one of two halves of the poses shows it"


@pytest.mark.parametrize(("most", "doubtful"), [(0.7, False), (0.5, True)])
def test_a_lowered_confidence_has_its_reason(periodic_diagnosis, most, doubtful):
    """A name that a rule limits has the rule in the report and in the lines of the command, whether it is still given or only most like."""
    (finding, *others) = periodic_diagnosis.findings
    limited = finding.limited(most, periodic_diagnosis.after.settings.naming.least_confidence, RULE)
    assert limited.doubtful is doubtful
    diagnosis = replace(periodic_diagnosis, findings=(limited, *others))
    for told in (render_report(diagnosis), describe_diagnosis(diagnosis)):
        assert f"no larger because {RULE}" in told or f"no more because {RULE}" in told


def test_a_confidence_of_the_trials_has_no_such_reason(periodic_diagnosis, periodic_page):
    """Without a rule that lowers it, neither says so."""
    assert "no larger because" not in periodic_page
    assert "no larger because" not in describe_diagnosis(periodic_diagnosis)
