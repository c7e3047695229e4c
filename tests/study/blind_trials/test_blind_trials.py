"""The blind trials: seeds do not depend on the number of sets, the dataset is blind, judgements and statistics agree with a second opinion."""

import json
import re
import shutil
import subprocess
import sys
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.stats import binomtest
from study.blind_trials.cases import load_study
from study.blind_trials.numbers import FORMAT, summarise
from study.blind_trials.run import SET_COLUMNS, injected_config, make_control, run_sets
from study.blind_trials.score import outcome, same_target
from study.blind_trials.statistics import half_point, half_point_interval, wilson

from scalar.effects.joint_hysteresis import JointHysteresis
from scalar.effects.joint_ripple import JointRipple
from scalar.effects.payload_deflection import PayloadDeflection
from scalar.effects.pose_lag import PoseLag
from scalar.effects.restarted_warm_up import RestartedWarmUp
from scalar.effects.sensor_map import SensorMap
from scalar.effects.target_drift import TargetDrift
from scalar.effects.torque_compliance import TorqueCompliance
from scalar.errors import InvalidInput

ROOT = Path(__file__).parents[3]
CONFIG = ROOT / "configs/blind_trials.yaml"
SMOKE = ROOT / "configs/blind_trials_smoke.yaml"
COMMITTED = ROOT / "paper/summaries/blind_trials"
SCHEMA = json.loads((ROOT / "tests/diagnosis/diagnosis.schema.json").read_text(encoding="utf-8"))
NAMES = set(SCHEMA["$defs"]["name"]["enum"]) - {
    "unattributed",
    JointHysteresis.name,
    JointRipple.name,
    PoseLag.name,
    SensorMap.name,
    PayloadDeflection.name,
    RestartedWarmUp.name,
    TargetDrift.name,
    TorqueCompliance.name,
}
"""All that can be injected alone: a ripple is named only beside all lower orders of its joint (tests/diagnosis/test_spectrum.py), a map is what a
crooked lens makes (tests/effects/test_sensor_map.py). A lag is newer than the committed tables (tests/diagnosis/test_moves.py). What needs
torques, a payload, a tracker or stops is newer too, and the scenes of these trials do not have it. They record directions of approach, with
which hysteresis is not looked for."""


@pytest.mark.parametrize(("k", "n"), [(0, 200), (3, 10), (19, 20), (20, 20)])
def test_an_interval_of_a_share_is_scipys(k, n):
    """Wilson's interval agrees with SciPy's implementation."""
    other = binomtest(k, n).proportion_ci(method="wilson")
    assert wilson(k, n) == pytest.approx((other.low, other.high), abs=1e-12)


def test_the_half_point_is_where_half_of_the_sets_are_found():
    """Of sets that are found with a chance that passes one half at 0.2, the half point is near 0.2 on average, and at least
    eight intervals of ten hold it.
    """
    x = np.repeat(np.geomspace(0.01, 3.0, 9), 40)
    chance = 1.0 / (1.0 + (0.2 / x) ** 2)
    points, held = [], 0
    for seed in range(10):
        found = (np.random.default_rng(seed).random(len(x)) < chance).astype(float)
        low, high = half_point_interval(x, found, np.tile(np.arange(40), 9).tolist())
        points.append(half_point(x, found))
        held += low <= 0.2 <= high
    assert np.exp(np.mean(np.log(points))) == pytest.approx(0.2, rel=0.15)
    assert held >= 8


def test_without_hits_there_is_no_half_point():
    """Without hits there is no half point; if everything is a hit, it lies below all values that were tried."""
    x = np.array([0.1, 0.1, 1.0, 1.0])
    assert np.isnan(half_point(x, np.zeros(4)))
    assert half_point(x, np.ones(4)) == 0.0


@pytest.mark.parametrize(
    ("name", "found", "injected", "right"),
    [
        ("joint_scale", {"joint": 2}, {"joint": 2}, True),
        ("joint_scale", {"joint": 2}, {"joint": 3}, False),
        ("joint_harmonic", {"joint": 2, "order": 3}, {"joint": 2, "order": 3}, True),
        ("joint_harmonic", {"joint": 2, "orders": [3, 4]}, {"joint": 2, "order": 3}, False),
        ("joint_harmonic", {"joint": 2, "orders": [3, 4]}, {"joint": 2, "orders": [4, 3]}, True),
        ("joint_compliance", {"joints": [2, 3]}, {"joints": [2, 3, 4]}, True),
        ("joint_compliance", {"joints": [2, 5]}, {"joints": [2, 3, 4]}, False),
        ("plane_moved", {"plane": "a", "at": {"order": 95.0}}, {"plane": "a", "at": {"order": 100}}, True),
        ("plane_moved", {"plane": "a", "at": {"order": 80.0}}, {"plane": "a", "at": {"order": 100}}, False),
        ("plane_moved", {"plane": "b", "at": {"order": 100.0}}, {"plane": "a", "at": {"order": 100}}, False),
    ],
)
def test_a_target_is_right_only_if_all_of_it_is(name, found, injected, right):
    """A target is right only if joint, order, target plane and moment are those of the injected effect."""
    assert same_target({"name": name, "target": found}, {"name": name, "target": injected}) is right


def test_an_answer_is_judged_by_its_first_effect():
    """The first effect decides whether an answer is right, listed beside another name, declared unobservable, missed, wrong or unattributed."""
    injected = {"name": "joint_scale", "target": {"joint": 2}}
    right = injected | {"confounded_with": []}
    other = {"name": "plane_bow", "target": {"plane": "floor"}, "confounded_with": []}
    assert outcome(injected, [right, other], []) == "right"
    assert outcome(injected, [other | {"confounded_with": [injected]}], []) == "listed"
    assert outcome(injected, [other, right], []) == "wrong"
    assert outcome(injected, [right | {"target": {"joint": 3}}], []) == "elsewhere"
    assert outcome(injected, [{"name": "unattributed", "target": {}}], []) == "unattributed"
    assert outcome(injected, [], [injected]) == "unobservable"
    assert outcome(injected, [], [injected | {"target": {"joint": 3}}]) == "missed"


def test_more_repetitions_do_not_change_the_first_sets():
    """No two workcells share a seed, and with more repetitions the first sets stay the same."""
    study = load_study(CONFIG)
    case = study.cases["joint_scale"]
    longer = replace(
        study, cases={**study.cases, "joint_scale": replace(case, repetitions=case.repetitions + 3)}
    )
    seeds = []
    for workcell in study.workcells:
        first = [s for s in study.sets("joint_scale", workcell, "001-002")]
        assert first == [s for s in longer.sets("joint_scale", workcell, "001-002")]
        seeds += [s.seed for s in longer.sets("joint_scale", workcell, f"001-{case.repetitions + 3:03d}")]
    assert len(set(seeds)) == len(seeds) // len(case.sizes)


def test_the_config_tries_every_effect_often_enough():
    """Every name that a diagnosis may give has at least 20 seeds, unless some robots cannot have it.

    There are 200 sets without effects, 60 with pairs, and 40 with unmodelled structure.
    """
    study = load_study(CONFIG)
    injected = {case.choices[0].entry["effect"] for case in study.cases.values() if case.kind == "single"}
    assert injected >= NAMES
    counts = dict.fromkeys(("single", "null", "pair", "unknown"), 0)
    for job in study.jobs():
        counts[study.cases[job[0]].kind] += len(list(study.sets(*job)))
    assert counts["null"] >= 200 and counts["pair"] >= 60 and counts["unknown"] >= 40
    for case in study.cases.values():
        if case.kind == "single":
            assert case.repetitions * len(case.choices[0].workcells) >= (
                20 if len(case.choices[0].workcells) > 4 else 16
            )


def test_a_misspelt_config_is_refused_by_name(tmp_path):
    """The message names the misspelt key and its place."""
    path = tmp_path / "loop.yaml"
    path.write_text(SMOKE.read_text(encoding="utf-8").replace("natural: 1.0e-3", "naturel: 1.0e-3"))
    with pytest.raises(InvalidInput, match="naturel"):
        load_study(path)
    path.write_text(
        SMOKE.read_text(encoding="utf-8").replace("[joint_scale, plane_moved]", "[joint_scael, plane_moved]")
    )
    with pytest.raises(InvalidInput, match="joint_scael"):
        load_study(path)


def test_a_size_beyond_any_number_is_refused_by_name(tmp_path):
    """A size of 400 digits, which no float can hold, is a fault of its key."""
    path = tmp_path / "loop.yaml"
    path.write_text(SMOKE.read_text(encoding="utf-8").replace("natural: 1.0e-3", f"natural: {'1' * 400}"))
    with pytest.raises(InvalidInput, match="natural"):
        load_study(path)


def test_the_diagnosis_is_blind(tmp_path):
    """What is diagnosed is what a reader of the dataset's folder gets, and but for the measured points it is what the same
    scene gives with nothing injected.
    """
    from study.common.in_memory import dataset_in_memory

    from scalar.data.dataset import read_dataset
    from scalar.simulation import simulate, write_scene

    study = load_study(SMOKE)
    (wanted,) = study.sets("joint_scale", "ur10e", "001-001")
    control = make_control(study, "ur10e", wanted.seed, ROOT)
    scene = simulate(injected_config(wanted, control), base_dir=control.base_dir, plan=control.plan)
    plain = simulate(control.config, base_dir=control.base_dir, plan=control.plan)
    assert scene.truth["effects"] and not plain.truth["effects"]
    given, without = dataset_in_memory(scene), dataset_in_memory(plain)
    write_scene(scene, tmp_path)
    read = read_dataset(tmp_path / "dataset")
    assert {field.name for field in fields(given)} == {field.name for field in fields(read)}
    np.testing.assert_allclose(given.points, read.points, atol=1e-9)
    for other in (read, without):
        # A folder names its run in addition: a checksum of what lies in it.
        assert (given.name, given.source) == (other.name, other.source.partition(", run ")[0])
        pd.testing.assert_frame_equal(given.poses, other.poses, check_dtype=False, check_like=True)
        assert given.robot.to_mapping() == other.robot.to_mapping()


@pytest.fixture(scope="module")
def sets():
    """Return two sets of the small blind trials: a scale error, and gross errors without an effect."""
    study = load_study(SMOKE)
    return study, pd.concat(
        [run_sets(study, case, "ur10e", "001-001", ROOT) for case in ("joint_scale", "null-gross_errors")],
        ignore_index=True,
    )


def test_a_set_is_injected_diagnosed_and_judged(sets):
    """A gross scale error is named with its joint, the error after is nearer to the floor than to before, and gross errors are no effect."""
    study, table = sets
    assert list(table.columns) == list(SET_COLUMNS)
    row = table.iloc[0]
    assert json.loads(row["found"])[0]["name"] == "joint_scale"
    assert abs(row["position_after_mm"] - row["position_control_mm"]) < abs(
        row["position_before_mm"] - row["position_after_mm"]
    )
    assert row["signal_over_noise"] > 1.0
    numbers, tables = summarise(table, study)
    assert numbers["natural_size"]["right"]["count"] == numbers["natural_size"]["right"]["sets"] == 1
    assert numbers["false_alarms"] | {"low": 0, "high": 0} == {
        "sets": 1,
        "count": 0,
        "share": 0.0,
        "low": 0,
        "high": 0,
    }
    assert tables["confusion"]["count"].sum() == 1


def test_the_committed_summaries_are_whole_and_small():
    """Every table is there, with a row for every effect of the catalogue and the seeds and code that made it, and all together are below 300 kB."""
    files = {path.name for path in COMMITTED.iterdir()}
    rules = (ROOT / "workflow/rules/blind_trials.smk").read_text(encoding="utf-8")
    listed = re.search(r"TRIALS_TABLES = \[(.*?)\]", rules, re.DOTALL)
    assert listed is not None
    assert files >= {f"{name}.csv" for name in re.findall(r'"(\w+)"', listed[1])} | {"numbers.json"}
    assert sum(path.stat().st_size for path in COMMITTED.iterdir()) < 300_000
    numbers = json.loads((COMMITTED / "numbers.json").read_text(encoding="utf-8"))
    assert numbers["format"] == FORMAT
    assert numbers["code"]["version"] and len(numbers["code"]["sources_sha256"]) == 64
    cases = load_study(CONFIG).cases
    assert set(numbers["seeds"]) == set(cases)
    named = {case.split("-")[0] for case in pd.read_csv(COMMITTED / "power.csv")["case"]}
    assert named >= NAMES
    assert set(pd.read_csv(COMMITTED / "thresholds.csv")["case"]) == {
        c.name for c in cases.values() if c.kind == "single"
    }


@pytest.mark.slow
def test_the_rules_run_small(tmp_path):
    """`snakemake blind_trials` on the small config makes every table and every figure, and a second call has nothing to do."""
    for name in ("scalar", "workflow", "configs", "paper"):
        shutil.copytree(ROOT / name, tmp_path / name, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(ROOT / "Snakefile", tmp_path)
    command = [sys.executable, "-m", "snakemake", "blind_trials", "--cores", "2", "--nocolor"]
    command += ["--configfile", "configs/smoke.yaml"]
    for words in ("steps (100%) done", "Nothing to be done"):
        ran = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
        assert ran.returncode == 0, ran.stdout + ran.stderr
        assert words in ran.stdout + ran.stderr
    made = tmp_path / "results/smoke/blind_trials"
    assert {path.stem for path in (made / "figures").glob("*.png")} == {
        "confusion",
        "power",
        "errors",
        "reliability",
    }
    assert (made / "summaries/numbers.json").exists()
