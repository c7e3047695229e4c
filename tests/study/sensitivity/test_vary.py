"""A set's rows: a diagnosis is run for exactly those variants that may answer otherwise, and what differs is told in words."""

import numpy as np
import pandas as pd
import pytest
from study.sensitivity.answers import KINDS, differences, refusal
from study.sensitivity.summary import numbers, still_open, tabulate
from study.sensitivity.variants import variants
from study.sensitivity.vary import RUN, SAME, UNUSED, vary

from scalar.errors import Undetermined

ANSWER = {
    "refused": "",
    "verdict": "effect",
    "effects": [
        {
            "name": "joint_scale",
            "target": '{"joint": 2}',
            "confidence": 0.9,
            "confounded": [],
            "coefficients": {"scale": 1e-3},
        }
    ],
    "unobservable": ["range_scale {}"],
    "set_aside": [[], 0, []],
    "fixed": ["d_1"],
    "held_out_mm": 0.1,
    "unseen_mm": 0.05,
    "stated_mm": 0.04,
}
"""An answer as a diagnosis might give it."""
NAMES = [
    "selection.swap_margin",
    "selection.max_effects",
    "selection.change_margin",
    "outer_split.least_selected",
    "hold_out.folds",
]
NO_GUARDS = pd.DataFrame(
    {"setting": ["hold_out.folds"], "guards": ["nothing"], "test": ["tests/x.py::test_y"]}
)


class Diagnosed:
    """Stands for a diagnosis: asks of a few settings, and counts how often it is asked itself."""

    def __init__(self):
        """Count the questions from zero."""
        self.asked = 0

    def __call__(self, settings):
        """Return an answer in which a margin above 5 takes a name away, and a least share below 0.3 is a refusal."""
        self.asked += 1
        if settings.outer_split.least_selected < 0.3:
            raise Undetermined("chosen too seldom")
        for effects in range(settings.selection.max_effects):
            if effects == 2:
                break
        if settings.selection.change_margin > 6:
            return {**ANSWER, "unseen_mm": 0.2}
        return (
            ANSWER
            if settings.selection.swap_margin < 5
            else {**ANSWER, "verdict": "no_effect", "effects": []}
        )


@pytest.fixture(scope="module")
def rows():
    """Return the rows of a set for five settings."""
    return vary("here", Diagnosed(), variants(NAMES))


def test_only_what_may_answer_otherwise_is_run(rows):
    """A diagnosis is run once by default, once traced, and once for each comparison that has another outcome.

    These are swap margin 6, change margin 12 and least selected 0.25. A loop whose bound is known only to the built-in ``range`` counts as one, and
    what is not asked for is not run.
    """
    answer = Diagnosed()
    vary("here", answer, variants(NAMES))
    how = rows.set_index(["setting", "direction"])["how"].to_dict()
    assert how["selection.swap_margin", "halved"] == SAME and how["selection.swap_margin", "doubled"] == RUN
    assert (
        how["outer_split.least_selected", "halved"] == RUN
        and how["outer_split.least_selected", "doubled"] == SAME
    )
    assert how["hold_out.folds", "halved"] == how["hold_out.folds", "doubled"] == UNUSED
    assert answer.asked == 2 + sum(value == RUN for value in how.values())


def test_what_changed_is_told_by_kind_the_gravest_first(rows):
    """A name that disappears changes the verdict too, a refusal is a kind of its own, and errors at other poses count."""
    changed = rows.set_index(["setting", "direction"])["changed"].to_dict()
    assert changed["selection.swap_margin", "doubled"] == "verdict;names"
    assert changed["outer_split.least_selected", "halved"] == "refused"
    assert changed["selection.change_margin", "doubled"] == "errors"
    assert sum(bool(kinds) for kinds in changed.values()) == 3


def test_a_diagnosis_that_cannot_be_traced_is_run_for_every_variant():
    """If tracing fails, every variant is run, and the answers are the same."""

    def stubborn(settings):
        if not isinstance(settings.selection.swap_margin, float):
            raise TypeError("a float, please")
        return ANSWER if settings.selection.swap_margin < 5 else {**ANSWER, "verdict": "no_effect"}

    found = vary("here", stubborn, variants(NAMES))
    assert set(found["how"]) == {RUN}
    assert list(found[found["changed"] != ""]["setting"]) == ["selection.swap_margin"]


@pytest.mark.parametrize(
    ("change", "kind"),
    [
        ({"verdict": "unattributed"}, "verdict"),
        ({"effects": []}, "names"),
        ({"effects": [{**ANSWER["effects"][0], "target": '{"joint": 3}'}]}, "targets"),
        ({"effects": [{**ANSWER["effects"][0], "confidence": 0.79}]}, "confidence"),
        ({"effects": [{**ANSWER["effects"][0], "confidence": 0.81}]}, ""),
        ({"effects": [{**ANSWER["effects"][0], "confounded": ["joint_harmonic {}"]}]}, "confounded"),
        ({"effects": [{**ANSWER["effects"][0], "coefficients": {"scale": 1.002e-3}}]}, "coefficients"),
        ({"effects": [{**ANSWER["effects"][0], "coefficients": {"scale": 1.0005e-3}}]}, ""),
        ({"unobservable": []}, "unobservable"),
        ({"set_aside": [[4], 0, []]}, "set_aside"),
        ({"fixed": ["d_1", "a_1"]}, "fixed"),
        ({"unseen_mm": 0.0501}, "errors"),
        ({"stated_mm": np.nan}, "errors"),
        ({"held_out_mm": 0.2}, ""),
        (refusal(Undetermined("too few poses")), "refused"),
    ],
)
def test_a_difference_belongs_to_its_kind(change, kind):
    """Each change of one statement is a difference of its own kind; equal values, or values within the tolerance, are no difference."""
    found = differences(ANSWER, {**ANSWER, **change})
    assert list(found) == ([kind] if kind else [])
    assert set(found) <= set(KINDS)
    assert differences(ANSWER, ANSWER) == {}


def test_the_table_counts_sets_and_names_the_gravest_first(rows):
    """Of two sets one changes nothing, so that shares are halves in either direction, and a guard is named only where nothing changed."""
    quiet = rows.assign(set="there", changed="", example="", how=SAME)
    table = tabulate(pd.concat([rows, quiet]), NO_GUARDS)
    by_name = table.set_index("setting")
    assert list(by_name["sets"].unique()) == [2]
    assert by_name.loc["selection.swap_margin", "naming_doubled"] == 1
    assert by_name.loc["selection.change_margin", "naming_doubled"] == 0
    assert by_name.loc["selection.change_margin", "unseen_worst"] == pytest.approx(3.0)
    assert by_name.loc["hold_out.folds", "test"] == "tests/x.py::test_y"
    assert table["setting"].iloc[-1] in ("selection.max_effects", "hold_out.folds")
    quoted = numbers(table, pd.concat([rows, quiet]))
    assert quoted["settings"]["all"] == len(NAMES) and quoted["settings"]["changed"] == 3
    assert quoted["settings"]["guarding"] == 1
    assert quoted["top"][0]["naming"] == pytest.approx(0.25)


def test_more_sets_are_for_settings_that_changed_or_were_never_run(rows):
    """A setting that was run without a change is not varied on more sets; one that changed an answer, or that no run tested, is."""
    assert set(still_open(rows)) == {
        "selection.swap_margin",
        "selection.change_margin",
        "outer_split.least_selected",
        "hold_out.folds",
    }
