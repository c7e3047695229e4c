"""What the paper counts in tables agrees with other tables and summaries of the same results, which count in another way."""

import json
from pathlib import Path

import pandas as pd
import pytest
from study.common.tables import read_table
from study.paper import committed

from scalar.effects.registry import known

ROOT = Path(__file__).parents[3]
SUMMARIES = ROOT / "paper/summaries"


def test_each_factor_counts_every_set_of_the_exam_once():
    """The levels of each factor together have the sets, and the answers of each kind, that the table of rates has for all sets."""
    table = read_table(SUMMARIES / "stratified/table.csv").query("row == 'all'").set_index("rate")
    for levels in committed.conditions(read_table(SUMMARIES / "stratified/conditions.csv")).values():
        rows = pd.DataFrame(levels.values())
        assert rows["sets"].sum() == table.loc["clean", "sets"]
        for rate in ("clean", "wrong", "wrong_sure", "worse"):
            assert rows[rate].sum() == table.loc[rate, "count"]


def test_sets_without_a_name_are_those_of_the_two_rows():
    """Sets with an unknown cause are as many, with as many clean ones, as the table of rates has in its two rows of such causes."""
    table = read_table(SUMMARIES / "stratified/table.csv")
    rows = table[table["row"].isin(("unknown cause", "shape also tried")) & (table["rate"] == "clean")]
    found = committed.conditions(read_table(SUMMARIES / "stratified/conditions.csv"))["injected"]["unknown"]
    assert (found["sets"], found["clean"]) == (rows["sets"].sum(), rows["count"].sum())


def test_sure_answers_are_those_from_the_threshold_on():
    """Bins from the threshold on are sure; the mean confidence of the others is weighted by their answers."""
    bins = [
        ("effect", 0.0, 0.5, 3, 0.2, 1),
        ("effect", 0.5, 0.8, 1, 0.6, 1),
        ("effect", 0.8, 1.0, 9, 0.9, 7),
        ("component", 0.0, 0.5, 0, None, 0),
    ]
    found = committed.confidence(
        pd.DataFrame(bins, columns=["of", "from", "to", "answers", "mean_stated", "right"])
    )
    assert found["effect"] == {"sure": 9, "sure_and_wrong": 2, "unsure": 4, "unsure_and_right": 2, "unsure_stated": pytest.approx(0.3)}  # fmt: skip
    assert found["component"]["unsure_stated"] is None


def test_pairs_that_can_be_separated_are_those_of_the_summary():
    """The table of pairs has as many that can be separated as the summary, and no more of them are named alone than are distinguished."""
    summary = json.loads((SUMMARIES / "planning/separation.json").read_text(encoding="utf-8"))["separable"]
    found = committed.separated(read_table(SUMMARIES / "planning/separation.csv"))
    assert found["pairs"] == summary["pairs"]
    assert 0 <= found["named_alone"] <= summary["diagnosed_planned"]["count"]
    assert 0 <= found["named_alone_at_random"] <= summary["diagnosed_random"]["count"]
    assert found["pairs"] <= found["open"]


def test_every_pair_is_either_open_or_should_be_separated_already():
    """Of four pairs two have a signal of five standard errors or more; the new diagnosis distinguishes three, and one has no true cause."""
    columns = [
        "pairs", "now", "separable", "distinguished", "distinguished_at_random", "right", "right_then", "right_then_at_random",
    ]  # fmt: skip
    rows = [
        (2, 1.0, True, True, False, "effect", True, False),
        (2, 6.0, True, True, True, "rival", False, False),
        (1, 4.9, False, False, False, "neither", False, False),
        (1, 50.0, True, True, False, "effect", False, False),
        (0, None, None, None, None, None, None, None),
    ]
    found = committed.separated(pd.DataFrame(rows, columns=columns))
    assert found == {
        "pairs": 1, "named_alone": 1, "named_alone_at_random": 0, "open": 2, "already": 2, "of_all_planned": 3, "of_all_at_random": 1, "neither": 1,
    }  # fmt: skip


def test_exams_are_compared_as_the_paper_prints_them():
    """2.41 and 2.407 are both 2.4; 300 is larger, and 1.04 is not."""
    assert committed.larger_as_printed([2.41, 2.407, 2.46, 300.0, 1.04], 2.407, 2) == 2


def test_sets_without_a_named_cause_are_counted_apart():
    """Of three sets with a named cause the diagnosis alone answers one and stepwise one; the set of an unknown cause is the diagnosis'."""
    clean = {
        "3 to 5 effects": [(True, True), (True, False), (False, True)],
        "unknown cause": [(True, False)],
    }
    rows, number = [], 0
    for row, answers in clean.items():
        for diagnosis, stepwise in answers:
            rows += [(number, row, "diagnosis", diagnosis), (number, row, "stepwise", stepwise)]
            rows.append((number, row, "gaussian-process", None))  # which gives no names
            number += 1
    found = committed.by_names(pd.DataFrame(rows, columns=["number", "row", "contestant", "clean"]))
    assert found["named"] == {
        "sets": 3,
        "diagnosis": 2,
        "stepwise": 2,
        "only_diagnosis": 1,
        "only_stepwise": 1,
    }
    assert found["unnamed"] == {
        "sets": 1,
        "diagnosis": 1,
        "stepwise": 0,
        "only_diagnosis": 1,
        "only_stepwise": 0,
    }


def test_confounded_pairs_add_up_to_the_summary():
    """The pairs of causes together are as many as the summary counts, and as many of them can be separated; none stands there in two orders."""
    summary = json.loads((SUMMARIES / "planning/separation.json").read_text(encoding="utf-8"))
    found = committed.confounded_pairs(read_table(SUMMARIES / "planning/separation.csv"))
    assert sum(entry["pairs"] for entry in found) == summary["pairs"]
    assert sum(entry["by_some"] for entry in found) == summary["separable"]["pairs"]
    assert sum(entry["by_all"] for entry in found) == summary["separable_by_all"]["pairs"]
    assert len({frozenset((entry["first"], entry["second"])) for entry in found}) == len(found)


def test_a_pair_of_causes_is_counted_in_either_order():
    """The effect and its rival may change places; a pair that the diagnosed poses separate already can be separated by nothing more."""
    columns = ["pairs", "effect", "rival", "now", "separable", "separable_by_all", "distinguished"]
    rows = [
        (1, "gear", "scale", 1.0, True, True, True),
        (1, "scale", "gear", 9.0, True, True, False),
        (2, "slip", "bow", 1.0, False, True, False),
        (0, None, None, None, None, None, None),
    ]
    table = pd.DataFrame(rows, columns=columns)
    assert committed.confounded_pairs(table.assign(distinguished_at_random=False)) == [
        {
            "first": "gear",
            "second": "scale",
            "pairs": 2,
            "by_some": 1,
            "by_all": 1,
            "planned": 1,
            "at_random": 0,
        },
        {
            "first": "bow",
            "second": "slip",
            "pairs": 1,
            "by_some": 0,
            "by_all": 1,
            "planned": 0,
            "at_random": 0,
        },
    ]


def test_the_documentation_has_the_same_pairs():
    """The table of docs/results.md has a row for each pair of causes, with the counts of the summary."""
    lines = (ROOT / "docs/results.md").read_text(encoding="utf-8").splitlines()
    for e in committed.confounded_pairs(read_table(SUMMARIES / "planning/separation.csv")):
        counts = " | ".join(str(e[key]) for key in ("pairs", "by_some", "by_all", "planned", "at_random"))
        assert f"| {e['first']}, {e['second']} | {counts} |" in lines


def test_strong_correlations_have_no_sign_and_occur_once():
    """Each pair of parameters with a correlation of either sign beyond the threshold occurs once, under the earlier of its names."""
    rows = [("a", 1.0, -0.9, 0.1), ("b", -0.9, 1.0, 0.75), ("c", 0.1, 0.75, 1.0)]
    table = pd.DataFrame(rows, columns=["parameter", "a", "b", "c"])
    assert committed.strong_correlations(table) == {"a": {"b": 0.9}, "b": {"c": 0.75}}


def test_errors_over_the_workspace_are_those_of_the_places_seen_from_the_side():
    """The same poses, seen from above, count in no place a second time."""
    table = pd.DataFrame({"view": ["side", "side", "above"], "after_mm": [0.02, 0.01, 0.5]})
    found = committed.over_workspace(table)
    assert found == {"places": 2, "after_least_mm": 0.01, "after_greatest_mm": 0.02}


def test_effects_that_begin_at_a_moment_state_it():
    """In the sets of the comparison with rivals, the effects that are counted, and no others, have a moment in their target."""
    table = read_table(ROOT / "benchmarks/diagnosis/results.csv")
    effects = [
        (n, e) for n, text in zip(table["number"], table["injected"], strict=True) for e in json.loads(text)
    ]
    assert {e["name"] for _, e in effects if "at" in e["target"]} <= set(committed.MOMENTS) <= set(known())
    assert committed.with_moment(table) == len({n for n, e in effects if "at" in e["target"]})


def test_only_sets_that_no_version_had_seen_are_counted():
    """A set that was run before counts for no contestant, and a contestant that gives no names has no count."""
    last = committed.RUN_BEFORE - 1
    rows = [(last, "a", True), (last + 1, "a", True), (last + 2, "a", False), (last + 1, "b", False), (last + 2, "b", False),
            (last + 1, "process", None), (last + 2, "process", None)]  # fmt: skip
    table = pd.DataFrame(rows, columns=["number", "contestant", "clean"])
    assert committed.not_run_before(table) == {"sets": 2, "a": 1, "b": 0}
