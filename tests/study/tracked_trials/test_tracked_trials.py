"""The tracked trials: what is drawn, the datasets that follow from it, and a small run."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml
from study.blind_trials.stratified_design import numbers_of
from study.tracked_trials.design import SENSORS, Design, load_tracked
from study.tracked_trials.measure import simulated
from study.tracked_trials.run import TRIAL_COLUMNS, run_trials
from study.tracked_trials.score import RATES
from study.tracked_trials.summaries import summarise_tracked
from study.tracked_trials.tracked_arm import robot_mapping
from study.tracked_trials.workcell import WORKCELL, TouchedPlane, Workcell, load_workcell

from scalar.errors import InvalidInput

ROOT = Path(__file__).parents[3]
CONFIG = ROOT / "configs/tracked_trials.yaml"
SMOKE = ROOT / "configs/tracked_trials_smoke.yaml"
RATIOS = {
    "right": 1,
    "fifth": 1 / 5,
    "three_times": 3,
}  # of the stated noise to the true one, by the names of the levels


@pytest.fixture(scope="module")
def design():
    """Return the committed design."""
    return load_tracked(CONFIG)


def test_jobs_hold_every_set_once(design):
    """The jobs have every set of every kind of sensor once."""
    small = Design(design.content | {"sets": {"probe": 23, "tracker": 5}, "sets_per_job": 10})
    held = [(sensor, k) for sensor, job in small.jobs() for k in numbers_of(job)]
    assert held == [("probe", k) for k in range(23)] + [("tracker", k) for k in range(5)]


def test_a_set_follows_from_the_seed_its_sensor_and_its_number(design):
    """A set is the same whichever other sets are drawn; no two sets share a seed, and another seed of the design gives other sets."""
    trials = [design.trial(sensor, k) for sensor in SENSORS for k in range(30)]
    assert trials == [load_tracked(CONFIG).trial(sensor, k) for sensor in SENSORS for k in range(30)]
    assert len({trial.seed for trial in trials}) == 90
    other = Design(design.content | {"seed": design.content["seed"] + 1})
    assert other.trial("probe", 3) != design.trial("probe", 3)


def test_sets_have_what_the_design_says(design):
    """Sizes are within their bounds, no cause occurs twice, and columns that a cause needs are recorded.

    Each statement about the noise occurs as often as in the design.
    """
    content = design.content
    trials = [design.trial(sensor, k) for sensor in SENSORS for k in range(40)]
    for trial in trials:
        names = [entry["name"] for entry in trial.causes]
        assert len(names) == len(set(names)) and len(names) in content["together"]
        for entry in trial.causes:
            low, high = content["effects"][entry["name"]]
            assert low <= abs(entry["size"]) <= high
        assert trial.records_time or "thermal_drift" not in names
        assert trial.records_approach or "joint_backlash" not in names
        assert trial.poses in content["poses"][trial.sensor]
        assert trial.sensor == "targets" or (trial.sessions == 1 and trial.turn_noise_rad is None)
        ratio = None if trial.stated_noise_m is None else trial.stated_noise_m / trial.noise_m
        assert ratio == (None if trial.stated == "none" else pytest.approx(RATIOS[trial.stated]))
    for sensor in SENSORS:
        counts = pd.Series([t.stated for t in trials if t.sensor == sensor]).value_counts()
        assert dict(counts) == {"right": 16, "fifth": 8, "three_times": 8, "none": 8}


@pytest.mark.parametrize(
    ("key", "value"),
    [("senors", 1), ("stated", ["twice"]), ("sets", {"scanner": 3}), ("poses", {"probe": [80]})],
)
def test_a_fault_of_the_config_is_refused(key, value, tmp_path):
    """The message names the place of the fault."""
    (tmp_path / "design.yaml").write_text(
        yaml.safe_dump(load_tracked(CONFIG).content | {key: value}), "utf-8"
    )
    with pytest.raises(InvalidInput, match=key):
        load_tracked(tmp_path / "design.yaml")


def test_a_fault_of_the_workcell_is_refused(tmp_path):
    """A misspelt key of the workcell is refused by its name, as one of a design is."""
    path = tmp_path / "workcell.yaml"
    path.write_text(WORKCELL.read_text(encoding="utf-8").replace("behind", "beyond"), encoding="utf-8")
    with pytest.raises(InvalidInput, match="behind"):
        load_workcell(path)


def test_every_robot_has_the_joints_of_the_workcell(design):
    """Each robot of the design has every joint that the workcell names, and one after each joint of which one is drawn."""
    workcell = load_workcell()
    last = max(*workcell.relative_compliance, *workcell.coupled_joints.values(), 1 + max(workcell.joints))
    assert all(len(robot_mapping(name)["joints"]) >= last for name in design.content["robots"])


def test_planes_and_joints_are_those_of_the_workcell(design):
    """With another workcell, the probe touches its planes, each in its direction, and causes act in its joints."""
    planes = tuple(TouchedPlane(f"side_{axis}_{k}", axis, 0.5) for k in range(2) for axis in range(3))
    workcell = Workcell(planes, (2,), {1: 1.0}, {"joint": 3, "source": 1})
    other = Design(design.content, workcell)
    targets = [cause["target"] for k in range(40) for cause in other.trial("probe", k).causes]
    assert {target["joint"] for target in targets if "joint" in target} == {2, 3}
    assert {tuple(target["joints"]) for target in targets if "joints" in target} == {(1,)}
    dataset, _, _ = simulated(other.trial("probe", 1))
    assert [plane.name for plane in dataset.planes] == [plane.name for plane in planes]
    assert set(dataset.poses["plane"]) == {plane.name for plane in planes}
    assert all(
        np.argmax(plane.normal) == touched.axis for plane, touched in zip(dataset.planes, planes, strict=True)
    )


@pytest.mark.parametrize("sensor", SENSORS)
def test_a_dataset_states_and_records_what_was_drawn(design, sensor):
    """The dataset has the sensor's kind and the noise as stated, and the same seed gives the same bytes."""
    trial = replace(design.trial(sensor, 1), stated="fifth", noise_m=5e-5, records_time=True)
    dataset, unseen, truth = simulated(trial)
    assert dataset.sensor.kind == ("probe" if sensor == "probe" else "tracker")
    assert dataset.sensor.noise == pytest.approx(1e-5)
    assert len(unseen) == len(truth) == trial.unseen
    assert 0.3 * trial.poses < len(dataset.poses) <= trial.poses
    np.testing.assert_array_equal(simulated(trial)[2], truth)


@pytest.mark.slow
def test_a_small_run_is_scored():
    """A set of each kind of sensor has all columns and gives the same answer twice, and the summaries count all sets."""
    small = load_tracked(SMOKE)
    sets = pd.concat([run_trials(small, sensor, range(1)) for sensor in SENSORS], ignore_index=True)
    assert list(sets.columns) == list(TRIAL_COLUMNS) and (sets["status"] == "diagnosed").all()
    again = run_trials(small, "tracker", range(1))
    assert again["found"][0] == sets["found"][0]
    assert again["unseen_after_mm"][0] == sets["unseen_after_mm"][0]
    numbers, tables = summarise_tracked(sets, small.content)
    assert numbers["sets"] == 3 and json.dumps(numbers)
    every = tables["table"].query("sensor == 'all' and stated == 'all'").set_index("rate")
    assert set(every.index) == set(RATES) and (every["sets"] == 3).all()
    assert (every["low"] <= every["share"]).all() and (every["share"] <= every["high"]).all()
    assert tables["causes"]["injected"].sum() == sum(len(json.loads(found)) for found in sets["injected"])
