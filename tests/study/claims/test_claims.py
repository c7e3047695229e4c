"""Verdicts on the original paper's claims follow their rules on both sides of every threshold, and depend on the tables alone."""

import numpy as np
import pandas as pd
import pytest
from study.claims.answers import Found, Results
from study.claims.judge import (
    ABSENT,
    CHANGED,
    CLAIM_COLUMNS,
    CONFIRMED,
    DIFFERS,
    FAILS,
    FAR,
    MOST,
    SAME,
    judge,
    judge_claims,
)
from study.claims.numbers import claim_numbers

STEP = 1e-6


def banded(value, low, high, least=None, most=None, **rest):
    """Return what a way to calibrate found; without a stated range, the range is as wide as the band."""
    return Found(
        "proposed",
        value,
        low,
        high,
        low if least is None else least,
        high if most is None else most,
        30,
        **rest,
    )


@pytest.mark.parametrize(
    ("rule", "published", "found", "verdict"),
    [
        ("reached", 1.0, banded(1.0, 0.9, 1.0), CONFIRMED),
        ("reached", 1.0, banded(0.9, 0.8, 1.0 - STEP), DIFFERS),
        ("reached", 1.0, banded(1.1, 1.0, 1.2), CONFIRMED),
        ("reached", 1.0, banded(1.1, 1.0 + STEP, 1.2), FAILS),
        ("reached", 1.0, banded(np.nan, np.nan, np.nan), FAILS),
        ("draw", 1.0, banded(0.5, 0.4, 0.6, 0.1, 1.0), CONFIRMED),
        ("draw", 1.0, banded(0.1, 0.1, 0.2, 0.1, 1.0 - STEP), DIFFERS),
        ("value", 1.0, banded(0.1, 0.1, 0.2, 0.1, 1.0), CONFIRMED),
        ("value", 1.0, banded(1 / FAR + STEP, 0.4, 0.6), DIFFERS),
        ("value", 1.0, banded(1 / FAR - STEP, 0.4, 0.6), FAILS),
        ("value", 1.0, banded(FAR + STEP, 1.5, 3), FAILS),
        ("enough", 1.0, banded(SAME - STEP, 1, 1), CONFIRMED),
        ("enough", 1.0, banded(SAME + STEP, 1, 1), DIFFERS),
        ("enough", 1.0, banded(CHANGED - STEP, 1, 1), DIFFERS),
        ("enough", 1.0, banded(CHANGED, 1, 1), FAILS),
        ("unaffected", 1.0, banded(1.0, 1, 1), CONFIRMED),
        ("unaffected", 1.0, banded(1 / SAME + STEP, 1, 1), CONFIRMED),
        ("unaffected", 1.0, banded(1 / SAME - STEP, 1, 1), DIFFERS),
        ("unaffected", 1.0, banded(CHANGED, 1, 1), FAILS),
        ("unaffected", 1.0, banded(1.0, 1, 1, succeeded=1 - STEP), DIFFERS),
        ("unaffected", 1.0, banded(1.0, 1, 1, succeeded=MOST - STEP), FAILS),
        ("within", 0.1, banded(MOST, 1, 1), CONFIRMED),
        ("within", 0.1, banded(MOST - STEP, 1, 1), DIFFERS),
        ("suffices", 1.0, banded(MOST, 1, 1), CONFIRMED),
        ("suffices", 1.0, banded(MOST - STEP, 1, 1), DIFFERS),
        ("suffices", 1.0, banded(0.5 - STEP, 1, 1), FAILS),
        ("everywhere", 1.0, banded(MOST, 1, 1), CONFIRMED),
        ("everywhere", 1.0, banded(0.5 - STEP, 1, 1), FAILS),
        ("fails", 1.0, banded(0.5, 1, 1), DIFFERS),
        ("fails", 1.0, banded(0.5 - STEP, 1, 1), FAILS),
        ("at_once", 1.0, banded(MOST - STEP, 1, 1), DIFFERS),
        ("count", 7.0, Found("", 7.0), CONFIRMED),
        ("count", 7.0, Found("", 8.0), FAILS),
        ("most", 0.5, Found("", 0.5 + STEP), CONFIRMED),
        ("most", 0.5, Found("", 0.5), FAILS),
        ("duration", 15.0, Found("proposed", 15.0 - STEP), CONFIRMED),
        ("duration", 15.0, Found("proposed", 15.0), FAILS),
        ("duration", 15.0, Found("proposed", np.nan), ABSENT),
        ("duration", 15.0, Found("proposed", 0.0), ABSENT),
        ("reached", 1.0, banded(1.0, 0.9, 1.0, succeeded=MOST - STEP), DIFFERS),
        ("reached", 1.0, banded(1.0, 0.9, 1.0, succeeded=MOST), CONFIRMED),
        ("enough", 1.0, banded(1.0, 1, 1, succeeded=MOST - STEP), DIFFERS),
        ("enough", 1.0, banded(CHANGED, 1, 1, succeeded=MOST - STEP), FAILS),
        ("value", 1.0, banded(1.0, 0.9, 1.1, succeeded=0.5), DIFFERS),
        ("fails", 1.0, banded(1.0, 1, 1), CONFIRMED),
        ("fails", 1.0, banded(1.0, 1, 1, succeeded=0.0), DIFFERS),
    ],
)
def test_each_rule_on_both_sides_of_its_threshold(rule, published, found, verdict):
    """The verdict changes at the threshold that the rule states."""
    assert judge(rule, published, found)[0] == verdict


@pytest.fixture(scope="module")
def published(request):
    """Return the claims of the paper."""
    return pd.read_csv(request.config.rootpath / "workflow/resources/judged_claims.csv")


def sweep(value_errors, **counts):
    """Return a sweep's summary with these medians by value of the axis, of one way."""
    common = {"walls": "upright", "method": "proposed", "alignment": "raw", "quantity": "position_mean_mm"}
    common |= {"seeds": 10, "failed": 0, "lost": 0} | counts
    return pd.DataFrame(
        [
            common | {"value": v, "median": e, "p05": e, "p95": e, "min": e, "max": e}
            for v, e in value_errors.items()
        ]
    )


def test_claims_without_a_table_stay_open(published):
    """Without any table, every claim is stated as absent from the run."""
    table = judge_claims(published, Results())
    assert list(table.columns) == list(CLAIM_COLUMNS)
    assert list(table["claim"]) == list(published["claim"])
    assert set(table["verdict"]) == {ABSENT}
    assert claim_numbers(table)["counts"][ABSENT.replace(" ", "_")] == len(published)


def test_verdicts_come_from_the_tables(published):
    """The verdicts change with the tables: sweeps, counts and planes of invented runs."""

    def verdicts(results):
        return {
            name: c["verdict"]
            for name, c in claim_numbers(judge_claims(published, results))["claims"].items()
        }

    planes = pd.DataFrame(
        {
            "method": ["proposed"] * 4,
            "seed": [1, 1, 2, 2],
            "distance_error_mm": [0.05, -0.05, 0.02, -0.2],
            "normal_error_deg": [0.001] * 4,
        }
    )
    flat = Results(
        sweeps={
            "poses": pd.concat([sweep({15: 9.0}, failed=6, lost=4), sweep({18: 197.0, 60: 1.0, 120: 1.0})]),
            "plane_tilt": sweep({1: 1.0, 30: 1.0}),
        },
        singular_values=pd.DataFrame({"null": [False] * 32 + [True] * 7}),
        planes=planes,
    )
    found = verdicts(flat)
    assert (
        found["poses_15"] == found["poses_18"] == found["poses_suffice"] == found["plane_tilt"] == CONFIRMED
    )
    assert found["redundant_sets"] == found["independent_columns"] == CONFIRMED
    assert (found["plane_distance"], found["plane_normal"]) == (
        DIFFERS,
        CONFIRMED,
    )  # one of two seeds is outside
    assert found["position_mean"] == ABSENT
    steep = Results(
        sweeps={
            "poses": sweep({15: 9.0, 18: 1.0, 60: 1.4, 120: 1.0}),
            "plane_tilt": sweep({1: 1.0, 30: 1.0}, lost=1),
        },
        singular_values=pd.DataFrame({"null": [False] * 33 + [True] * 6}),
        planes=planes.assign(distance_error_mm=1.0),
    )
    found = verdicts(steep)
    for name in ("poses_15", "poses_18", "poses_suffice", "plane_tilt", "redundant_sets", "plane_distance"):
        assert found[name] == FAILS, name


def test_the_rule_at_once_is_judged_by_its_worst_case(published):
    """A claim that holds in the first case, but not in every case, differs."""
    common = {
        "stage": "one_pass",
        "alignment": "raw",
        "quantity": "position_mean_mm",
        "seeds": 30,
        "way": "robot_first",
    }

    def verdict(*shares):
        rows = [common | {"case": str(i), "worse_than_at_once": share} for i, share in enumerate(shares)]
        table = judge_claims(published, Results(sequential=pd.DataFrame(rows)))
        return table.set_index("claim").loc["at_once", "verdict"]

    assert verdict(1.0, 1.0) == CONFIRMED
    assert verdict(1.0, 0.3) == DIFFERS
    assert verdict(0.4, 1.0) == FAILS


def test_a_seed_without_a_calibration_has_no_plane_within_its_limits(published):
    """The share is over all seeds, not only over those with a calibration."""
    planes = pd.DataFrame(
        {
            "method": ["initial", "initial", "proposed"],
            "seed": [1, 2, 1],
            "distance_error_mm": [9.0, 9.0, 0.01],
            "normal_error_deg": [9.0, 9.0, 0.001],
        }
    )
    rows = judge_claims(published, Results(planes=planes)).set_index("claim")
    assert rows.loc["plane_distance", ["found", "seeds", "verdict"]].tolist() == [0.5, 2, DIFFERS]


def test_a_way_that_always_fails_confirms_nothing(published):
    """A claim that few poses do not suffice is confirmed only by a method that succeeds with many."""

    def verdict(failed_with_many):
        few = sweep({15: 9.0}, failed=10)
        many = sweep({120: 1.0}, failed=failed_with_many)
        results = Results(sweeps={"poses": pd.concat([few, many])})
        return judge_claims(published, results).set_index("claim").loc["poses_15", "verdict"]

    assert verdict(0) == CONFIRMED
    assert verdict(10) == DIFFERS


def test_more_points_than_parameters_are_judged_by_the_fits_that_succeed(published):
    """A fit that fails, or that ends far from the truth, with many points of few poses contradicts the claim."""

    def verdict(**bad):
        results = Results(sweeps={"poses": sweep({15: 9.0}, **bad)})
        return (
            judge_claims(published, results)
            .set_index("claim")
            .loc["points_over_parameters", ["found", "verdict"]]
        )

    assert verdict().tolist() == [1.0, CONFIRMED]
    assert verdict(failed=2, lost=1).tolist() == [0.7, DIFFERS]
    assert verdict(failed=6, lost=4).tolist() == [0.0, FAILS]


def test_the_accuracy_all_over_the_workspace_is_judged_by_place(published):
    """Every place counts alike, whatever the number of its poses, and the view from above, which has the same poses again, is left out."""
    side = [("side", 1, 0.08), ("side", 900, 0.02), ("side", 2, 0.3), ("above", 900, 0.3)]
    workspace = pd.DataFrame(side, columns=["view", "poses", "after_mm"]).assign(seeds=30)

    def row(table):
        return judge_claims(published, Results(workspace=table)).set_index("claim").loc["whole_workspace"]

    assert row(workspace)[["found", "seeds", "verdict"]].tolist() == [pytest.approx(2 / 3), 30, DIFFERS]
    assert row(workspace.iloc[:2])["verdict"] == CONFIRMED
    assert row(workspace.iloc[:0])["verdict"] == ABSENT


def test_the_table_contains_no_time(published):
    """No time is written to the table, so that it is the same on every machine that is fast enough."""
    one, two = (judge_claims(published, Results(seconds={"proposed": s})) for s in (0.1, 3.0))
    pd.testing.assert_frame_equal(one, two)
