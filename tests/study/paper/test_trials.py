"""The numbers of the blind trials that the paper quotes: intervals agree with a second opinion, counts add up, and no bad case is left out."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from study.blind_trials.statistics import clustered_interval, wilson
from study.common.effect_words import case_words
from study.common.tables import read_table
from study.paper.reported import TABLES
from study.paper.trials import STRATIFIED_RATIOS, reported_stratified, reported_trials, with_ratios

from scalar.effects.registry import known

SUMMARIES = Path(__file__).parents[3] / "paper/summaries"


@pytest.fixture(scope="module")
def reported():
    """Return what is quoted of the committed tables."""
    return reported_trials({name: read_table(SUMMARIES / "blind_trials" / f"{name}.csv") for name in TABLES})


@given(st.lists(st.booleans(), min_size=2, max_size=12), st.integers(1, 5))
def test_copies_within_a_scene_add_nothing(hits, copies):
    """A scene that is diagnosed several times with the same end is one trial: the interval stays as it is."""
    scenes = list(range(len(hits)))
    once = clustered_interval(np.array(hits, float), scenes)
    repeated = clustered_interval(
        np.repeat(np.array(hits, float), copies), np.repeat(scenes, copies).tolist()
    )
    assert repeated == pytest.approx(once, abs=1e-12)
    low, high = once
    assert 0.0 <= low <= np.mean(hits) + 1e-12 and np.mean(hits) - 1e-12 <= high <= 1.0


def test_where_all_scenes_are_alike_the_interval_is_wilsons():
    """If all scenes are hits or none is, the interval is Wilson's for one trial per scene."""
    assert clustered_interval(np.ones(40), [k % 8 for k in range(40)]) == wilson(8, 8)
    assert clustered_interval(np.zeros(40), [k % 8 for k in range(40)]) == wilson(0, 8)


def test_independent_scenes_have_the_interval_of_independent_trials():
    """With one set a scene the bootstrap agrees with Wilson's interval to its own accuracy."""
    hits = np.arange(200) % 10 > 0
    assert clustered_interval(hits.astype(float), list(range(200))) == pytest.approx(
        wilson(180, 200), abs=0.012
    )


def test_every_set_is_counted_once(reported):
    """Shares are of all sets, and the gain that leaves no residual is counted in one of them and not in the other."""
    natural = reported["natural"]
    assert natural["all"]["sets"] == natural["observable"]["sets"] + natural["unobservable"]["sets"]
    assert natural["all"]["count"] == natural["observable"]["count"] + natural["unobservable"]["named"]
    assert (
        natural["observable"]["sets"] - natural["observable"]["count"] == natural["observable"]["not_right"]
    )
    smaller = reported["smaller"]
    assert (
        smaller["named"] + smaller["missed"] + smaller["unattributed"] + smaller["unobservable"]
        == smaller["sets"]
    )
    unknown = read_table(SUMMARIES / "blind_trials/unknown.csv")
    groups = [reported["unknown"][group] for group in ("same_formula", "imitated", "other")]
    for size in ("natural", "smaller"):
        assert sum(group[size]["sets"] for group in groups) == unknown["unattributed_sets"].sum() / 2
    assert sum(group["kinds"] for group in groups) == unknown["case"].nunique()


def test_the_committed_scenes_agree_with_the_committed_workcells():
    """The committed tables by scene and by workcell count the same sets."""
    scenes = read_table(SUMMARIES / "blind_trials/by_scene.csv").groupby(["case", "workcell"])["right"]
    cells = read_table(SUMMARIES / "blind_trials/by_workcell.csv").set_index(["case", "workcell"])
    assert scenes.sum().to_dict() == cells["right"].to_dict()
    assert scenes.size().to_dict() == cells["sets"].to_dict()


def test_every_effect_was_injected_or_is_listed_as_not_injected(reported):
    """Each effect of the catalogue was injected or is in the list, which an effect joins with the catalogue."""
    tried = {case.split("-")[0] for case in read_table(SUMMARIES / "blind_trials/power.csv")["case"]}
    every = {*known(), "pose_jitter", "scan_bias"} - {"unattributed"}
    assert set(reported["not_injected"]) == {case_words(name) for name in every - tried}
    assert {"gear error of many orders", "lag of joints"} <= set(
        reported["not_injected"]
    ) and "joint_scale" in tried


def test_the_worst_correction_comes_first(reported):
    """No effect whose correction is farther from the control is left out before one that is nearer."""
    worst = [row["median"] for row in reported["after_over_control"]["worst"]]
    errors = read_table(SUMMARIES / "blind_trials/errors.csv")
    named = errors[(errors["size"] == 1) & ~errors["case"].str.startswith(("null", "pairs", "unknown"))]
    assert worst == sorted(worst, reverse=True)
    assert worst[0] == named["after_over_control"].max()


@pytest.mark.parametrize("name", ["table", "exams/1", "exams/4"])
def test_stratified_rates_add_up(name):
    """The row of all is the sum of the rows; what was not recorded stays open."""
    reported = reported_stratified(read_table(SUMMARIES / f"stratified/{name}.csv"))
    for rate in ("clean", "worse", "much_worse"):
        assert reported["all"][rate]["count"] == sum(row[rate]["count"] for row in reported["rows"])
    assert reported["all"]["sets"] == sum(row["sets"] for row in reported["rows"])
    missed = [row["missed"]["count"] for row in reported["rows"]]
    assert reported["all"]["missed"]["count"] == (None if None in missed else sum(missed))


def test_each_row_of_the_exam_has_its_error_over_the_floor():
    """Beside the rates stand the median, 95 % quantile and greatest ratio of the same row; the greatest of all is that of the worst row."""
    folder = SUMMARIES / "stratified"
    rates = reported_stratified(read_table(folder / "table.csv"))
    ratios = read_table(folder / "ratios.csv")
    found = with_ratios(rates, ratios)
    without = [{k: v for k, v in row.items() if k not in STRATIFIED_RATIOS} for row in found["rows"]]
    assert without == rates["rows"]
    every = [row["after_over_floor"] for row in (*found["rows"], found["all"])]
    assert all(0 < one["median"] <= one["p95"] <= one["greatest"] for one in every)
    assert max(one["greatest"] for one in every[:-1]) == every[-1]["greatest"]
    of_row = ratios[(ratios["row"] == found["rows"][0]["row"]) & (ratios["ratio"] == "after_over_floor")]
    assert list(of_row["value"]) == [every[0][key] for key in ("median", "p95", "greatest")]
    nameless = ratios[(ratios["row"] == "unknown cause") & ratios["ratio"].isin(STRATIFIED_RATIOS[1:])]
    assert nameless.empty and all(
        "after_over_told" not in row for row in found["rows"] if row["row"] == "unknown cause"
    )
