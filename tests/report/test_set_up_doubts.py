"""What is suspected of the set-up stands at the head of the report of a diagnosis, as it does on the terminal."""

from dataclasses import replace

from scalar.diagnosis import Diagnosis
from scalar.estimation.setup.suspicion import Suspicion
from scalar.estimation.suspected_setup import with_suspicions
from scalar.report import render_report


def test_a_doubt_of_the_set_up_is_in_the_report(null_diagnosis: Diagnosis) -> None:
    """The page has the sentence, as text whatever its characters are; without a doubt it has no such line."""
    doubt = Suspicion("session", "pose 70", "poses 60 to 69 <b> are set aside")
    before = with_suspicions(null_diagnosis.calibration_before, [doubt])
    page = render_report(replace(null_diagnosis, calibration_before=before))
    assert "Check the set-up: poses 60 to 69 &lt;b&gt; are set aside" in page
    assert "Check the set-up" not in render_report(null_diagnosis)
