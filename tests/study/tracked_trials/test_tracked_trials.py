"""The tracked trials: what is drawn, the mechanics of the arm, contacts in their order, judgements, and a small run."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml
from study.blind_trials.stratified_design import numbers_of
from study.common import kinematics
from study.tracked_trials.design import SENSORS, Design, load_tracked
from study.tracked_trials.flawed_arm import Acquisition, FlawedArm
from study.tracked_trials.measure import FIRST, contacts, simulated
from study.tracked_trials.run import TRIAL_COLUMNS, run_trials, unseen_error
from study.tracked_trials.score import RATES, tracked_score
from study.tracked_trials.summaries import summarise_tracked
from study.tracked_trials.tracked_arm import TrackedArm, robot_mapping
from study.tracked_trials.workcell import WORKCELL, TouchedPlane, Workcell, load_workcell

from scalar.errors import InvalidInput
from tests.tracked_targets import drawn_arm

ROOT = Path(__file__).parents[3]
CONFIG = ROOT / "configs/tracked_trials.yaml"
SMOKE = ROOT / "configs/tracked_trials_smoke.yaml"
RATIOS = {
    "right": 1,
    "fifth": 1 / 5,
    "three_times": 3,
}  # of the stated noise to the true one, by the names of the levels
SIZES = {"joint_harmonic": 3e-4, "joint_scale": 1e-3, "joint_backlash": 4e-4, "pose_lag": 1e-3}


@pytest.fixture(scope="module")
def design():
    """Return the committed design."""
    return load_tracked(CONFIG)


@pytest.fixture(scope="module")
def arm():
    """Return a true arm."""
    return drawn_arm(np.random.default_rng(1), (FIRST,))


def cause(name, target=None, **more):
    """Return an injected cause."""
    return {"name": name, "target": target or {}, "size": SIZES.get(name, 1e-5), **more}


def acquisition(n, rng, jitter=0.0):
    """Return an acquisition of n poses of an arm with six joints."""
    time = np.arange(n) * 30.0
    approach = np.sign(rng.normal(size=(n, 6)))
    return Acquisition(time, max(time[-1], 1.0) / 3, approach, jitter * rng.normal(size=(n, 6)))


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


def test_an_arm_without_causes_is_rigid(arm):
    """An arm without causes is rigid; so is, at rest, an arm whose causes act only during an acquisition."""
    rng = np.random.default_rng(2)
    q = arm.poses(20, rng)
    rigid = kinematics.chain(arm.geometry, q) @ arm.T_n_flange
    moving = [cause("joint_backlash", {"joint": 2}), cause("pose_lag", {"joint": 1}), cause("thermal_drift")]
    np.testing.assert_array_equal(FlawedArm(arm, []).flange(q), rigid)
    np.testing.assert_array_equal(FlawedArm(arm, moving).flange(q), rigid)
    assert np.abs(FlawedArm(arm, moving).flange(q, acquisition(20, rng)) - rigid).max() > 1e-5


def test_a_loaded_arm_gives_way_downwards(arm):
    """With compliant joints or a compliant base the potential energy falls, in proportion to the compliance."""
    q = arm.poses(50, np.random.default_rng(3))
    for name, target in (("joint_compliance", {"joints": [2, 3]}), ("base_compliance", {})):
        rigid = FlawedArm(arm, []).flange(q)[:, 2, 3]
        once = FlawedArm(arm, [cause(name, target)]).flange(q)[:, 2, 3] - rigid
        twice = FlawedArm(arm, [cause(name, target) | {"size": 2e-5}]).flange(q)[:, 2, 3] - rigid
        assert once.mean() < -1e-4
        np.testing.assert_allclose(twice, 2 * once, atol=0.02 * np.abs(once).max())


def test_torques_are_weights_times_levers(arm):
    """Joint 1 is upright and bears no torque, so turning it lifts nothing, and the moment about the base turns with it."""
    q = arm.poses(10, np.random.default_rng(4))
    upright = TrackedArm(
        arm.name, arm.geometry * np.array([1, 1, 1, 1, 0])[:, None], arm.targets, arm.T_tracker_base
    )
    upright.geometry[:2, 0] = 0.0  # the first joint stands in the middle of the base
    turned = q + np.eye(6)[0] * 0.7
    energy, moment = FlawedArm(upright, []).moments(q)
    energy_turned, moment_turned = FlawedArm(upright, []).moments(turned)
    np.testing.assert_allclose(energy_turned, energy)
    turn = kinematics.rotation(2, 0.7)[:2, :2]
    np.testing.assert_allclose(moment_turned, moment @ turn.T)


def test_contacts_lag_behind_the_pose_that_is_kept_before_them(arm):
    """Poses that reach nothing are left out before the steps between poses are made: the dataset's own angles bring the tip to its planes."""
    rng = np.random.default_rng(5)
    flawed = FlawedArm(arm, [cause("pose_lag", {"joint": 2}), cause("joint_backlash", {"joint": 3})])
    q, during = arm.poses(40, rng), acquisition(40, rng, jitter=2e-5)
    places = arm.at(q, FIRST)[:, :3, 3]
    normals = np.tile([0.0, 0.0, 1.0], (40, 1))
    distances = np.full(40, np.quantile(places[:, 2], 0.4))
    distances[[3, 17, 18]] = 9.0  # out of reach
    solved, kept = contacts(flawed, q, during, normals, distances)
    assert not kept[[3, 17, 18]].any() and 20 < len(solved) == kept.sum() < 40
    heights = (flawed.flange(solved, during.of(kept)) @ arm.targets[FIRST])[:, 2, 3]
    np.testing.assert_allclose(heights, distances[kept], atol=2e-9)


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


def test_an_error_is_taken_after_base_and_scale_are_placed():
    """A moved base adds no error, nor does a scale if it is free."""
    rng = np.random.default_rng(6)
    truth = np.stack([kinematics.random_transform(rng, 1.0, 1.0) for _ in range(30)])
    moved = kinematics.random_transform(rng, 2.0, 1.5) @ truth
    assert unseen_error(moved, truth) < 1e-12
    moved[:, :3, 3] *= 1.001
    assert unseen_error(moved, truth) > 5e-4
    assert unseen_error(moved, truth, scaled=True) < 1e-12


def entry(name, target=None, confidence=0.9, confounded_with=()):
    """Return an entry of diagnosis.json."""
    more = {"confidence": confidence, "confounded_with": list(confounded_with)}
    return {"name": name, "target": target or {}, **more}


HARMONIC = cause("joint_harmonic", {"joint": 2, "order": 5})
SOFT = cause("joint_compliance", {"joints": [2, 3]})
UNKNOWN = cause("unknown", {"joint": 2})
JUDGED = [
    ([], [], {"clean"}),
    ([], [entry("base_compliance")], {"wrong", "wrong_sure"}),
    ([], [entry("base_compliance", confidence=0.5)], {"wrong"}),
    ([], [entry("unattributed")], {"unattributed"}),
    ([HARMONIC], [], {"missed"}),
    ([HARMONIC], [entry("joint_harmonic", {"joint": 2, "orders": [1, 5]})], {"clean"}),
    ([HARMONIC], [entry("joint_harmonic", {"joint": 2, "order": 5})], {"clean"}),
    ([HARMONIC], [entry("joint_harmonic", {"joint": 3, "order": 5})], {"missed", "wrong", "wrong_sure"}),
    ([HARMONIC], [entry("joint_scale", {"joint": 2}, 0.9, [HARMONIC])], set()),
    ([SOFT], [entry("joint_compliance", {"joints": [3]})], {"clean"}),
    ([SOFT], [entry("joint_compliance", {"joints": [2, 4]})], {"missed", "wrong", "wrong_sure"}),
    ([UNKNOWN], [entry("unattributed")], {"clean", "unattributed"}),
    ([UNKNOWN], [], {"missed"}),
]


@pytest.mark.parametrize(("causes", "found", "expected"), JUDGED)
def test_a_set_is_judged(causes, found, expected):
    """Each set counts to the expected rates, of which several may apply."""
    score = tracked_score(causes, True, found, [], {"before": 1.0, "after": 0.5})
    assert set(score) == set(RATES)
    assert {name for name in RATES if score[name]} == expected


def test_what_cannot_be_seen_or_does_not_repeat_is_no_fault():
    """A cause that is said to be unobservable is not missed; a jitter is a wrong name only of joints that repeat."""
    errors = {"before": 1.0, "after": 1.0}
    assert not tracked_score([HARMONIC], True, [], [entry("joint_harmonic", HARMONIC["target"])], errors)[
        "missed"
    ]
    assert tracked_score([], True, [entry("pose_jitter")], [], errors)["wrong_sure"]
    assert tracked_score([], False, [entry("pose_jitter")], [], errors)["clean"]


@pytest.mark.parametrize(("after", "worse"), [(1.04, False), (1.06, True), (None, False)])
def test_after_is_held_against_before(after, worse):
    """A correction is worse if the error over unseen poses grows by 5 % or more, and without an answer the set has failed."""
    score = tracked_score([], True, [], [], {"before": 1.0, "after": after})
    assert score["worse"] == worse and score["failed"] == (after is None)


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
