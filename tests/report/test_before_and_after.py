"""The report says near its top how wrong the arm is by its data sheet, and how wrong with what it ships."""

import html
import re

from scalar.diagnosis.result import Diagnosis
from scalar.report import render_report
from scalar.report.diagnosed_workspace import before_and_after_in_words, diagnosed_workspace


def test_the_beginning_states_the_numbers_of_the_table(periodic_diagnosis: Diagnosis) -> None:
    """The sentence stands before the first heading, with the figures of the first and the last row of the table, and no others."""
    section = diagnosed_workspace(periodic_diagnosis)
    assert section is not None
    first, last = section["rows"][0], section["rows"][-1]
    said = before_and_after_in_words(periodic_diagnosis)
    assert all(
        text in said for text in (first["mean"]["value"], first["most"]["value"], *last["mean"].values())
    )
    assert (first["state"], last["state"]) == ("data sheet", "after.json")
    page = html.unescape(re.sub("</?strong>", "", render_report(periodic_diagnosis)))
    beginning, _, rest = page.partition("<h2>")
    assert said in beginning and said not in rest
