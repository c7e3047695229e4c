"""A scene with something injected: the matched control of the one without, its truth complete, its dataset without a word of it."""

import json
import re

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner

from scalar.cli import cli
from scalar.data.dataset import read_dataset
from scalar.data.io.plain_yaml import dump_yaml
from scalar.errors import InvalidInput
from scalar.simulation import simulate, write_scene
from tests.simulation.injecting import ENTRIES, config_with, injected, plan_of

NOISE = {"range_noise_std_m": 1e-4, "scan_bias_std_m": 5e-5, "joint_noise_std_rad": 2e-5}
INTERFACE = {
    "joint_compliance": {"joints"}, "joint_harmonic": {"joint", "order"}, "joint_scale": {"joint"},
    "joint_coupling": {"joint", "source"}, "joint_backlash": {"joint"}, "joint_hysteresis": {"joint"}, "pose_lag": {"joint"},
    "axis_nonparallel": {"joint"},
    "base_compliance": set(), "thermal_drift": set(), "restarted_warm_up": set(), "target_drift": set(), "torque_compliance": {"joints"},
    "payload_deflection": {"joints"}, "sensor_slip": {"at"}, "range_scale": set(),
    "range_offset": set(), "range_distortion": set(), "plane_bow": {"plane"}, "plane_moved": {"plane", "at"},
    "pose_jitter": set(), "scan_bias": set(),
}  # fmt: skip


@pytest.fixture(scope="module")
def control():
    """Return the scene without any effect."""
    return injected(noise=NOISE)


@pytest.mark.parametrize("name", ENTRIES)
def test_an_effect_changes_neither_poses_nor_chance(name, control):
    """Poses, columns, rays and noise of the points are the control's, whatever was injected."""
    scene = injected(ENTRIES[name], noise=NOISE)
    pd.testing.assert_frame_equal(scene.poses, control.poses)
    np.testing.assert_array_equal(scene.angles, control.angles)
    assert scene.dataset == control.dataset
    if not name.startswith(("range", "scan_bias")):
        errors = [np.linalg.norm(s.points, axis=2) - s.ranges for s in (scene, control)]
        np.testing.assert_allclose(*errors, atol=1e-15)
    assert np.abs(scene.points - control.points).max() > 1e-5


def test_jitter_and_bias_enlarge_their_noise(control):
    """An injected variance is added to the declared one, and the errors are the same draws, scaled."""
    jittery = injected({"effect": "pose_jitter", "size": 1e-4}, noise=NOISE)
    ratio = (jittery.q_true - jittery.q) / (control.q_true - control.q)
    np.testing.assert_allclose(ratio, np.hypot(1e-4, 2e-5) / 2e-5, rtol=1e-6)
    biased = injected({"effect": "scan_bias", "size": 2e-4}, noise=NOISE | {"range_noise_std_m": 0.0})
    plain = injected(noise=NOISE | {"range_noise_std_m": 0.0})
    ratio = np.divide(*(np.linalg.norm(s.points, axis=2) - s.ranges for s in (biased, plain)))
    np.testing.assert_allclose(ratio, np.hypot(2e-4, 5e-5) / 5e-5, rtol=1e-6)


@pytest.mark.parametrize("name", ENTRIES)
def test_the_truth_names_what_was_injected(name):
    """The truth has the documented name and target, the size with its unit, and is JSON."""
    entry = ENTRIES[name]
    scene = injected(entry)
    (truth,) = json.loads(json.dumps(scene.truth, allow_nan=False))["effects"]
    assert truth["name"] == entry["effect"]
    assert truth["size"] > 0 and truth["unit"]
    if entry["effect"] == "unknown":
        assert truth["kind"] == entry["kind"] and truth["depends_on"]
    else:
        expected = {"joint", "orders"} if name == "harmonics" else INTERFACE[entry["effect"]]
        assert set(truth["target"]) == expected
    resized = injected(entry | {"size": truth["size"] * 2}).truth["effects"][0]
    assert resized["target"] == truth["target"]
    assert resized["size"] == truth["size"] * 2


def test_targets_are_drawn_from_the_seed():
    """Over seeds joints, orders, target planes and moments vary; moments lie in the middle half of the run."""
    entries = [{"effect": name} for name in ("joint_harmonic", "plane_bow", "sensor_slip", "joint_coupling")]
    drawn = [injected(*entries, seed=seed, poses_per_plane=6).truth["effects"] for seed in range(6)]
    for k in range(len(entries)):
        assert len({json.dumps(effects[k]["target"]) for effects in drawn}) >= 3
    for effects in drawn:
        assert 18 * 0.25 <= effects[2]["target"]["at"]["order"] < 18 * 0.75
        assert effects[3]["target"]["joint"] > effects[3]["target"]["source"]


def test_one_effect_does_not_move_the_other():
    """What is drawn for the first entry does not depend on what follows it; both are in the truth, in order."""
    first, second = {"effect": "joint_harmonic"}, {"effect": "plane_moved"}
    both = injected(first, second).truth["effects"]
    assert both[0] == injected(first).truth["effects"][0]
    assert [entry["name"] for entry in both] == ["joint_harmonic", "plane_moved"]


def test_joints_add_up_and_arms_follow_each_other():
    """With two errors of joints and a slip, the frames are those of the sum of the joints' errors, followed by the slip."""
    joint = {"effect": "joint_scale", "target": {"joint": 2}}
    other = {"effect": "joint_coupling", "target": {"joint": 5, "source": 4}}
    slip = {"effect": "sensor_slip", "target": {"at": {"order": 10}}}
    plain, jointly = injected(joint, other, slip), injected(other, joint)
    slipped = injected({"effect": "joint_scale", "target": {"joint": 1}, "size": 1e-12}, joint, slip)
    np.testing.assert_allclose(plain.T_base_sensor[:10], jointly.T_base_sensor[:10], atol=1e-13)
    motion = np.linalg.inv(jointly.T_base_sensor[10:]) @ plain.T_base_sensor[10:]
    np.testing.assert_allclose(motion, np.tile(motion[0], (len(motion), 1, 1)), atol=1e-12)
    assert np.linalg.norm(motion[0, :3, 3]) == pytest.approx(2e-3, abs=1e-12)
    assert slipped.truth["effects"][2]["shift_m"] == plain.truth["effects"][2]["shift_m"]


def numbers_in(value):
    """Return all numbers in a nested structure."""
    if isinstance(value, dict):
        return [x for item in value.values() for x in numbers_in(item)]
    if isinstance(value, list):
        return [x for item in value for x in numbers_in(item)]
    return [value] if isinstance(value, float) else []


@pytest.mark.parametrize("name", ENTRIES)
def test_the_dataset_tells_nothing(name, tmp_path):
    """`scalar simulate` writes a valid dataset in which neither a name nor a number of what was injected stands."""
    dump_yaml(config_with(ENTRIES[name], poses_per_plane=4), tmp_path / "scene.yaml")
    done = CliRunner().invoke(cli, ["simulate", str(tmp_path / "scene.yaml"), "-o", str(tmp_path / "out")])
    assert done.exit_code == 0, done.output
    checked = CliRunner().invoke(cli, ["validate", str(tmp_path / "out/dataset")])
    assert checked.exit_code == 0, checked.output
    folder = tmp_path / "out/dataset"
    text = (folder / "dataset.yaml").read_text()
    truth = json.loads((tmp_path / "out/truth/truth.json").read_text())
    words = {ENTRIES[name]["effect"], *re.split("_", ENTRIES[name]["effect"]), "injected", "effect", "masses"}
    for word in words - {"joint", "plane", "range", "sensor", "pose", "axis"}:  # words of the format
        assert not re.search(rf"\b{word}", text), word
    for entry in truth["effects"]:
        entry.pop("ranges_rad", None)  # the ends of recorded angles
    hidden = [x for x in numbers_in(truth["effects"]) if x not in (0.0, 1.0) and len(repr(x)) > 6]
    recorded = {
        repr(x) for column in ("time", "temperature") for x in pd.read_csv(folder / "poses.csv")[column]
    }
    text += (folder / "poses.csv").read_text()
    assert not [x for x in hidden if repr(abs(x))[:10] in text and repr(x) not in recorded]
    assert read_dataset(folder).n_poses == 12


def test_the_columns_are_the_same_with_and_without(control):
    """A workcell that records everything has the same files whether or not something is injected."""
    assert list(control.poses) == [
        "pose",
        "plane",
        *(f"q{j}" for j in range(1, 7)),
        "time",
        "temperature",
        *(f"approach{j}" for j in range(1, 7)),
        *("payload", "payload_x", "payload_y", "payload_z"),
        *(f"tau{j}" for j in range(1, 7)),
    ]
    assert list(injected(record=[]).poses) == ["pose", "plane", *(f"q{j}" for j in range(1, 7))]
    needed = injected({"effect": "joint_backlash"}, record=[])
    assert [name for name in needed.poses if name.startswith("approach")] == [
        f"approach{j}" for j in range(1, 7)
    ]
    assert (np.diff(control.poses["time"]) > 0).all()


@pytest.mark.slow
def test_same_seed_same_bytes(tmp_path):
    """A scene with all effects at once gives the same files twice."""
    config = config_with(*ENTRIES.values())
    for name in ("a", "b"):
        write_scene(simulate(config, plan=plan_of("ur10e")), tmp_path / name)
    for file in (path.relative_to(tmp_path / "a") for path in (tmp_path / "a").rglob("*.*")):
        assert (tmp_path / "a" / file).read_bytes() == (tmp_path / "b" / file).read_bytes()


FAULTS = [
    ({"effect": "joint_harmonc"}, r"injected\[0\]\.effect: unknown \('joint_harmonc'\).*did you mean 'joint_harmonic'"),
    ({"effect": "joint_scale", "target": {"jiont": 2}}, r"injected\[0\]\.target\.jiont: unknown key.*'joint'"),
    ({"effect": "joint_scale", "siez": 1e-3}, r"injected\[0\]\.siez: unknown key.*did you mean 'size'"),
    ({"effect": "plane_bow", "target": {"joint": 2}}, r"injected\[0\]\.target\.joint: unknown key.*plane"),
    ({"effect": "plane_bow", "target": {"plane": "flor"}}, r"injected\[0\]\.target\.plane: no plane 'flor'.*floor"),
    ({"effect": "joint_scale", "target": {"joint": 7}}, r"injected\[0\]\.target\.joint: there is no joint 7"),
    ({"effect": "joint_compliance", "target": {"joints": [2, 9]}}, r"injected\[0\]\.target\.joints.*joint 9"),
    ({"effect": "joint_coupling", "target": {"joint": 2, "source": 2}}, r"injected\[0\]\.target\.source"),
    ({"effect": "joint_harmonic", "target": {"order": 2, "orders": [3]}}, r"injected\[0\]\.target\.orders"),
    ({"effect": "joint_harmonic", "target": {"order": 2}, "phases_rad": [0, 1]}, r"injected\[0\]\.phases_rad: 2 phases"),
    ({"effect": "sensor_slip", "target": {"at": {"order": 36}}}, r"injected\[0\]\.target\.at\.order.*0 to 35"),
    ({"effect": "thermal_drift", "lengths": ["a_7"]}, r"injected\[0\]\.lengths: 'a_7' is no length"),
    ({"effect": "unknown", "kind": "angle_bmp"}, r"injected\[0\]\.kind: unknown \('angle_bmp'\).*did you mean 'angle_bump'"),
    ({"effect": "joint_backlash", "recorded": False, "target": {"joint": 1}}, r"injected\[0\]\.target\.joint.*weight"),
    ({"effect": "scan_bias", "size": 0}, r"injected\[0\]\.size"),
    ("joint_scale", r"injected\[0\]: not a mapping \('joint_scale'\)"),
    ({}, r"injected\[0\]\.effect: missing; add it"),
]  # fmt: skip


@pytest.mark.parametrize(("entry", "message"), FAULTS, ids=lambda x: str(x)[:50])
def test_a_fault_is_named_where_it_stands(entry, message):
    """A misspelt effect, target or option, or one that this workcell does not have, is refused by its place."""
    with pytest.raises(InvalidInput, match=message) as caught:
        injected(entry)
    assert len(str(caught.value).splitlines()) == 1


@pytest.mark.parametrize("entry", [FAULTS[0][0], FAULTS[4][0], FAULTS[13][0]])
def test_a_fault_ends_with_status_2(entry, tmp_path):
    """On the command line a fault is a line on stderr, without traceback, and nothing is written."""
    dump_yaml(config_with(entry), tmp_path / "scene.yaml")
    done = CliRunner().invoke(cli, ["simulate", str(tmp_path / "scene.yaml"), "-o", str(tmp_path / "out")])
    assert done.exit_code == 2
    assert "injected[0]" in done.stderr and "Traceback" not in done.stderr
    assert not (tmp_path / "out").exists()
