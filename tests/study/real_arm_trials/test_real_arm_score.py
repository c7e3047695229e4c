"""Answers of the real-arm trials are judged and counted."""

import json
from pathlib import Path

import pandas as pd
import pytest
from study.real_arm_trials.design import load_real_arm
from study.real_arm_trials.run import TRIAL_COLUMNS, run_trials
from study.real_arm_trials.score import RATES, real_arm_score
from study.real_arm_trials.summaries import summarise_real_arm

ROOT = Path(__file__).parents[3]
SMOKE = ROOT / "configs/real_arm_trials_smoke.yaml"


def entry(name, target=None, confidence=0.9, **more):
    """Return an entry of diagnosis.json."""
    return {"name": name, "target": target or {}, "confidence": confidence, **more}


def row(injected, found, unobservable=(), after=0.5, **more):
    """Return the row of a set whose first cause is judged."""
    return (
        {
            "instrument": "tracker",
            "effect": injected[0].get("kind", injected[0]["name"]) if injected else "none",
            "size": "natural" if injected else "none",
            "company": len(injected[1:]),
            "status": "diagnosed",
            "repeatability_rad": 0.0,
            "injected": json.dumps(injected),
            "found": json.dumps(found),
            "unobservable": json.dumps(list(unobservable)),
            "unseen_before_mm": 1.0,
            "unseen_after_mm": after,
            "simulate_s": 1.0,
            "diagnose_s": 2.0,
        }
        | {
            key: ""
            for key in (
                "number",
                "seed",
                "attempt",
                "robot",
                "poses",
                "noise_m",
                "states_noise",
                "record",
                "sessions",
                "reason",
            )
        }
        | more
    )


LAG = {"name": "pose_lag", "target": {"joint": 2}, "size": 1e-3}
SPRING = {"name": "unknown", "kind": "forearm_spring", "target": {"joint": 2}, "size": 3e-4}
DRIFT = {"name": "target_drift", "target": {}, "size": 1e-4}
JUDGED = [
    (row([LAG], [entry("pose_lag", {"joint": 2})]), {"right"}),
    (row([LAG], [entry("pose_lag", {"joint": 3})]), {"missed", "wrong", "wrong_sure"}),
    (row([LAG], [entry("joint_scale", {"joint": 2}, 0.7)]), {"missed", "wrong"}),
    (row([LAG], [entry("joint_scale", {"joint": 2}, 0.9, confounded_with=[LAG])]), {"listed"}),
    (row([LAG], [], [entry("pose_lag", {"joint": 2})]), {"listed"}),
    (row([LAG], [entry("unattributed")]), {"unattributed"}),
    (row([LAG], []), {"missed"}),
    (row([LAG, DRIFT], [entry("target_drift", {"at": {"order": 7.0, "time": None}})]), {"missed"}),
    (row([SPRING], [entry("unattributed")]), {"right"}),
    (row([SPRING], [entry("base_compliance", confidence=0.85)]), {"missed", "wrong", "wrong_sure"}),
    (row([], []), set()),
    (row([], [entry("unattributed", confidence=0.4)]), {"false_alarm"}),
    (row([], [entry("target_drift")]), {"false_alarm", "wrong", "wrong_sure"}),
    (row([], [entry("pose_jitter")], repeatability_rad=1e-5), set()),
    (row([], [entry("pose_jitter")]), {"false_alarm", "wrong", "wrong_sure"}),
    (row([LAG], [entry("pose_lag", {"joint": 2})], after=1.06), {"right", "worse"}),
    (row([LAG], [], status="NotIdentifiable", unseen_after_mm=float("nan")), {"failed"}),
]


@pytest.mark.parametrize(("of_set", "expected"), JUDGED)
def test_a_set_is_judged(of_set, expected):
    """Each set counts to the expected rates, of which several may apply."""
    score = real_arm_score(of_set)
    assert set(score) == set(RATES)
    assert {name for name, counts in score.items() if counts} == expected


def test_rates_are_shares_of_the_sets_to_which_they_apply():
    """Powers are of the sets with an effect and false alarms of those without; each fault is listed with its set."""
    sets = pd.DataFrame([of_set for of_set, _ in JUDGED])
    numbers, tables = summarise_real_arm(sets, load_real_arm(SMOKE).content)
    assert numbers["sets"] == {"with_an_effect": 12, "without": 5}
    table = tables["table"].set_index(["instrument", "effect", "size", "company", "rate"]).sort_index()
    every = table.loc[("all", "all", "all", "all")]
    assert dict(every["sets"]) == {rate: 12 for rate in ("right", "listed", "unattributed", "missed")} | {
        "wrong": 17, "wrong_sure": 17, "worse": 17, "failed": 17, "false_alarm": 5,
    }  # fmt: skip
    assert every.loc["right", "count"] == 3 and every.loc["false_alarm", "count"] == 3
    assert (every["low"] <= every["share"]).all() and (every["share"] <= every["high"]).all()
    assert table.loc[("tracker", "forearm_spring", "natural", "alone", "wrong_sure"), "count"] == 1
    assert len(tables["faults"]) == 7
    assert tables["errors"]["ratio_largest"].max() == pytest.approx(1.06)


@pytest.mark.slow
def test_a_small_run_is_scored():
    """A set of each instrument has all columns and gives the same answer twice, and the summaries count all sets."""
    small = load_real_arm(SMOKE)
    sets = pd.concat(
        [run_trials(small, instrument, range(3, 4), ROOT) for instrument in ("tracker", "rail", "scanner")],
        ignore_index=True,
    )
    assert list(sets.columns) == list(TRIAL_COLUMNS) and (sets["status"] == "diagnosed").all()
    again = run_trials(small, "rail", range(3, 4), ROOT)
    assert again["found"][0] == sets["found"][1] and again["unseen_after_mm"][0] == sets["unseen_after_mm"][1]
    numbers, tables = summarise_real_arm(sets, small.content)
    assert numbers["sets"] == {"with_an_effect": 3, "without": 0} and json.dumps(numbers)
    assert set(tables) == {"table", "errors", "faults"}
