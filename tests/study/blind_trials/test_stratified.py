"""The stratified blind trials: every pair of conditions occurs, sets do not depend on their number, judgements, and a small run."""

import json
from collections import Counter
from itertools import product
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml
from study.blind_trials.stratified_design import FACTORS, Design, load_design, numbers_of, pairs_of, row_of
from study.blind_trials.stratified_run import TRIAL_COLUMNS, run_trials, scenes
from study.blind_trials.stratified_score import FAIR, trial_score
from study.blind_trials.stratified_summaries import (
    RATES,
    ROWS,
    condition_counts,
    confidence_bins,
    kind_of_injected,
    rate_table,
    ratios,
    set_aside_by_scanner,
    summarise_trials,
)

from scalar.errors import InvalidInput
from scalar.simulation.injected.causes import CAUSES
from scalar.simulation.injected.unknown import KINDS

ROOT = Path(__file__).parents[3]
CONFIG = ROOT / "configs/blind_trials_stratified.yaml"
SMOKE = ROOT / "configs/blind_trials_stratified_smoke.yaml"
ERRORS = {"before": 1.0, "after": 0.1, "floor": 0.1}
NOTHING = {"injected": [], "scanner": None, "surface": None}


@pytest.fixture(scope="module")
def design():
    """Return the committed design."""
    return load_design(CONFIG)


@pytest.mark.parametrize("sets", [300, 3000])
def test_every_pair_of_conditions_occurs(design, sets):
    """Every pair of levels occurs, about as often as every other pair of the same two factors."""
    trials = design.trials(sets)
    counted = Counter(pair for trial in trials for pair in pairs_of(trial.conditions))
    levels = design.levels()
    for k, first in enumerate(FACTORS):
        for second in FACTORS[k + 1 :]:
            times = [counted[first, a, second, b] for a, b in product(levels[first], levels[second])]
            fair = sets / len(times)
            assert min(times) >= 1 and max(abs(np.array(times) - fair)) <= max(3, 0.1 * fair)


def test_a_longer_design_begins_with_a_shorter_one(design):
    """More sets do not change the first ones, so that a run that was stopped can be resumed; the same file gives the same sets."""
    assert design.trials(40) == load_design(CONFIG).trials(60)[:40]
    assert len({trial.seed for trial in design.trials(200)}) == 200


@pytest.mark.parametrize("name", ["../design.yaml", "/etc/hostname", "link.yaml", "a\0b"])
def test_a_design_extends_files_of_its_own_folder_alone(name, tmp_path):
    """A path upwards, an absolute path and a link out of the folder are refused with the name of the key, and the file is not read."""
    (tmp_path / "design.yaml").write_text(CONFIG.read_text("utf-8"), "utf-8")
    (tmp_path / "in").mkdir()
    (tmp_path / "in/link.yaml").symlink_to(tmp_path / "design.yaml")
    (tmp_path / "in/mine.yaml").write_text(yaml.safe_dump({"extends": name, "sets": 10}), "utf-8")
    with pytest.raises(InvalidInput, match="extends: leads out of the folder"):
        load_design(tmp_path / "in/mine.yaml")


def test_jobs_hold_every_set_once(design):
    """With any number of sets in a job, the jobs together have every set once."""
    small = Design(design.content | {"sets": 23, "sets_per_job": 10})
    assert [k for job in small.jobs() for k in numbers_of(job)] == list(range(23))


def test_each_row_of_the_table_is_large_enough(design):
    """Of 3,000 sets, each row of the table for which a rate is required has about 300 or more."""
    rows = Counter(trial.row for trial in design.trials())
    assert set(rows) <= set(ROWS)
    for row in (
        "no effect, imperfect",
        "one effect, imperfect",
        "3 to 5 effects",
        "60 poses",
        "unknown cause",
    ):
        assert rows[row] >= 290


def test_causes_and_shapes_are_apart(design):
    """Shapes whose formula the estimator has too are counted in a row of their own; the causes are ten or more of those of the simulator."""
    in_other_trials = {
        "forearm_spring"
    }  # of the real-arm trials: this design is older, and a new cause would change its sets
    assert set(design.content["causes"]) == set(CAUSES) - in_other_trials and len(CAUSES) >= 10
    assert set(design.content["shapes"]) == set(KINDS)
    assert set(FAIR) <= set(CAUSES)
    conditions = {"scanner": "white", "surface": "flat", "poses": 300}
    assert row_of(conditions | {"injected": "shape"}) != row_of(conditions | {"injected": "cause"})


def test_a_trial_has_what_its_conditions_say(design):
    """A trial has the number of effects of its conditions, no effect twice, none that its robot cannot have, and sizes within bounds."""
    together = {"none": 0, "one": 1, "three": 3, "four": 4, "five": 5, "cause": 1, "shape": 1}
    robots = design.content["robots"]
    for trial in design.trials(120):
        assert len(trial.injected) == together[trial.conditions["injected"]]
        names = [entry["effect"] for entry in trial.injected]
        assert len(set(names)) == len(names)
        assert not (trial.conditions["robot"] == "panda" and "axis_nonparallel" in names)
        for entry in trial.injected:
            natural = next(
                block[name]
                for block in (design.content["effects"], design.content["causes"], design.content["shapes"])
                for name in (entry["effect"], entry.get("kind"))
                if name in block
            )
            natural *= robots[trial.conditions["robot"]].get("times", {}).get(entry["effect"], 1.0)
            assert 0.7 <= entry["size"] / natural <= 1.5


@pytest.mark.parametrize("robot", ["small_arm", "large_arm"])
def test_arms_at_the_ends_of_size_see_their_planes(design, robot):
    """The smallest and the largest arm, both invented, can be simulated with an imperfect scanner, surfaces and an effect at once."""
    conditions = {"scanner": "speckle", "surface": "wavy", "injected": "one", "poses": 60, "robot": robot}
    simulated, floor = scenes(design, design.trial(0, conditions), ROOT)
    assert len(simulated.poses) == len(floor.poses) == 60
    reach = np.linalg.norm(simulated.T_base_sensor[:, :3, 3], axis=1).max()
    assert reach < (0.6 if robot == "small_arm" else 3.5)


def test_a_misspelt_key_is_refused(tmp_path):
    """The message names the place of the fault."""
    content = yaml.safe_load(CONFIG.read_text(encoding="utf-8"))
    content["scannners"] = content.pop("scanners")
    path = tmp_path / "design.yaml"
    path.write_text(yaml.safe_dump(content), encoding="utf-8")
    with pytest.raises(InvalidInput, match="scann"):
        load_design(path)


def entry(name, confidence=0.9, target=None, confounded_with=()):
    """Return an entry of diagnosis.json."""
    return {
        "name": name,
        "target": target or {},
        "confidence": confidence,
        "confounded_with": list(confounded_with),
    }


def injected(name, target=None, **more):
    """Return a truth with one effect."""
    return NOTHING | {"injected": [{"name": name, "target": target or {}, **more}]}


SCALE = injected("joint_scale", {"joint": 2})
CASES = [
    (NOTHING, [], {"clean"}),
    (NOTHING, [entry("pose_jitter")], {"wrong", "wrong_sure", "wrong_noise"}),
    (NOTHING, [entry("joint_scale", 0.5, {"joint": 2})], {"wrong"}),
    (NOTHING, [entry("unattributed")], {"unattributed", "sure_structure"}),
    (NOTHING | {"surface": {"bow_m": 2e-4}}, [entry("plane_bow", target={"plane": "floor"})], {"clean"}),
    (NOTHING | {"scanner": {"linearity_m": 5e-5}}, [], {"clean", "flaw_unseen"}),
    (NOTHING | {"scanner": {"linearity_m": 5e-5}}, [entry("sensor_map")], {"clean"}),
    (SCALE, [entry("joint_scale", target={"joint": 2})], {"clean"}),
    (SCALE, [entry("joint_scale", target={"joint": 3})], {"missed", "wrong", "wrong_sure"}),
    (SCALE, [], {"missed"}),
    (SCALE, [entry("unattributed")], {"unattributed", "sure_structure"}),
    (SCALE, [entry("joint_coupling", 0.9, {"joint": 2, "source": 1}, SCALE["injected"])], {"missed"}),
    (injected("unknown", kind="hose"), [entry("unattributed")], {"clean", "unattributed"}),
    (injected("unknown", kind="hose"), [], {"missed"}),
    (injected("unknown", kind="giving_floor"), [entry("base_compliance")], {"fair"}),
    (injected("unknown", kind="hose"), [entry("base_compliance", 0.5)], {"wrong"}),
    (injected("unknown", {"joint": 3}, kind="encoder_interpolation"), [entry("pose_jitter")], {"fair"}),
    (
        injected("unknown", {"joint": 3}, kind="encoder_interpolation"),
        [entry("pose_jitter", 0.5, {"joint": 2})],
        {"wrong", "wrong_noise"},
    ),
]


@pytest.mark.parametrize(("truth", "found", "expected"), CASES)
def test_a_set_is_judged(truth, found, expected):
    """Each set counts to the expected rates, of which several may apply; components of the scanner's noise are not judged."""
    score = trial_score(truth, found, [], ERRORS)
    assert {name for name in RATES if score.get(name)} == expected


def test_an_effect_that_cannot_be_seen_and_is_said_so_is_not_missed():
    """An effect that is listed as unobservable with its target is not missed."""
    assert not trial_score(SCALE, [], SCALE["injected"], ERRORS)["missed"]


@pytest.mark.parametrize(
    ("after", "worse", "much"), [(1.04, False, False), (1.1, True, False), (1.3, True, True)]
)
def test_after_is_held_against_before_and_floor(after, worse, much):
    """A correction is worse by the ratio of mean errors over the unseen poses; a missing answer counts as infinitely worse."""
    score = trial_score(NOTHING, [], [], {"before": 1.0, "after": after, "floor": 0.5})
    assert (score["worse"], score["much_worse"]) == (worse, much)
    assert score["after_over_floor"] == pytest.approx(2 * after)
    assert trial_score(NOTHING, [], [], {"before": None, "after": None, "floor": 0.5})["much_worse"]


def test_intervals_hold_what_was_drawn():
    """With 400 sets the intervals of shares and of quantiles lie near the true values, and their ends are ordered."""
    rng = np.random.default_rng(0)
    columns = {rate: rng.random(400) < 0.3 for rate in RATES}
    sets = pd.DataFrame(
        columns
        | {"row": "60 poses", "after_over_floor": rng.lognormal(0, 0.3, 400), "after_over_before": 1.0}
        | {"after_over_told": np.where(np.arange(400) < 300, 2.0, np.nan), "told_over_floor": np.nan}
    )
    for row in rate_table(sets).to_dict("records"):
        assert row["low"] <= row["share"] <= row["high"] and row["low"] < 0.36 and row["high"] > 0.24
    middle = ratios(sets).query("ratio == 'after_over_floor' and quantile == 0.5").iloc[0]
    assert middle["low"] <= 1.0 <= middle["high"] and middle["high"] - middle["low"] < 0.15
    told = ratios(sets).query("ratio == 'after_over_told'")
    assert (told["value"] == 2.0).all() and (told["sets"] == 300).all()
    assert "told_over_floor" not in set(ratios(sets)["ratio"])


def test_answers_are_counted_by_what_they_state():
    """Effects and variance components are counted separately; an answer without a stated confidence is in no bin."""
    rows = [
        ("effect", 0.99, True),
        ("effect", 1.0, False),
        ("effect", 0.3, True),
        ("component", 0.85, False),
        ("effect", None, True),
    ]
    bins = confidence_bins(pd.DataFrame(rows, columns=["of", "confidence", "right"]))
    top = bins.query("of == 'effect' and to == 1.0").iloc[0]
    assert (top["answers"], top["right"]) == (2, 1)
    assert bins["answers"].sum() == 4


def test_sets_are_counted_by_how_many_effects_they_have(design):
    """The kind of a set follows from its level of the design, and every factor counts each set once, whatever the sizes of its effects."""
    kinds = {"three": "3", "four": "4", "five": "5", "one": "1", "cause": "unknown", "shape": "unknown"}
    trials = design.trials(120)
    for trial in trials:
        names = [{"name": entry["effect"]} for entry in trial.injected]
        assert kind_of_injected(names) == kinds.get(trial.conditions["injected"], "none")
    rows = [
        trial.conditions
        | {"injected": json.dumps([{"name": e["effect"], "size": k} for e in trial.injected])}
        | {rate: k % 2 == 0 for rate in ("clean", "wrong", "wrong_sure", "worse")}
        for k, trial in enumerate(trials)
    ]
    counts = condition_counts(pd.DataFrame(rows))
    assert list(counts["factor"].unique()) == list(FACTORS)
    assert (counts.groupby("factor")["sets"].sum() == 120).all()
    assert (counts.groupby("factor")["clean"].sum() == 60).all()
    assert set(counts.query("factor == 'injected'")["level"]) == {"none", *kinds.values()}


def test_good_poses_that_are_set_aside_are_counted_by_scanner():
    """Poses of the sets that were diagnosed and counted are counted; tables of runs without the count give no number."""
    columns = ["scanner", "poses", "set_aside", "status"]
    rows = [("mixed", 60, 1, "diagnosed"), ("mixed", 300, 2, "diagnosed"), ("white", 60, 0, "diagnosed")]
    rows += [("white", 60, None, "Undetermined"), ("white", 120, None, "diagnosed")]
    sets = pd.DataFrame(rows, columns=columns)
    found = set_aside_by_scanner(sets)
    assert found == {"mixed": {"poses": 360, "set_aside": 3}, "white": {"poses": 60, "set_aside": 0}}
    assert set_aside_by_scanner(sets.drop(columns="set_aside")) == {}


@pytest.mark.slow
def test_a_small_run_is_scored():
    """Two sets of the small design have all columns, are the same in a second run, and the summaries have every row that occurs."""
    small = load_design(SMOKE)
    sets = run_trials(small, range(1, 3), ROOT)
    assert list(sets.columns) == list(TRIAL_COLUMNS) and list(sets["number"]) == [1, 2]
    assert (sets["status"] == "diagnosed").all()
    again = run_trials(small, range(2, 3), ROOT)
    assert again["found"].tolist() == sets["found"].tolist()[1:]
    assert again["position_after_mm"].tolist() == sets["position_after_mm"].tolist()[1:]
    numbers, tables = summarise_trials(sets, {"seed": 7, "sealed_after": "0" * 40})
    assert numbers["design"]["seed"] == 7 and numbers["design"]["sealed_after"] == "0" * 40
    ratio = tables["ratios"].query("ratio == 'told_over_floor' and row == 'all' and quantile == 0.5")
    assert len(ratio) == sets["position_told_mm"].notna().any()
    named = numbers["named_by_significance"]
    injected = [
        e
        for row in sets["injected"]
        for e in json.loads(row)
        if e["name"] not in ("unknown", "pose_jitter", "scan_bias")
    ]
    assert sum(group["injected"] for group in named.values()) <= len(injected)
    assert all(0 <= group["named"] <= group["injected"] for group in named.values())
    assert numbers["sets"] == 2 and set(tables["table"]["row"]) == {*sets["row"], "all"}
    assert json.dumps(numbers)
