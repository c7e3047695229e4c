"""The blind sets: a config that is checked, and sensors that measure the same arm."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from study.sensitivity.datasets import make_dataset
from study.sensitivity.sets import BlindSet, Sets, load_sets

from scalar.diagnosis.settings import DEFAULTS
from scalar.errors import InvalidInput
from scalar.estimation.calibrate import calibrate
from scalar.estimation.settings import documentation

ROOT = Path(__file__).parents[3]
GUARDS = pd.read_csv(ROOT / "workflow/resources/guarding_settings.csv")
TABLE = pd.read_csv(ROOT / "paper/summaries/sensitivity/settings.csv")
NOISE = 1e-4  # m


def test_the_sets_have_every_sensor_arm_and_kind_of_trouble():
    """There are sixty sets, of which twelve are run for every setting; both groups have all sensors, arms and kinds of trouble."""
    sets = load_sets(ROOT / "configs/sensitivity.yaml")
    assert (len(sets.screened), len(sets.sets)) == (12, 60)
    for names in (sets.screened, sets.others):
        chosen = [sets.sets[name] for name in names]
        assert {wanted.sensor for wanted in chosen} == {"line_laser", "tracker", "probe"}
        assert {wanted.workcell for wanted in chosen} == set(sets.workcells)
        assert any(not wanted.injected for wanted in chosen)
        assert any(len(wanted.injected) == 2 for wanted in chosen)
        assert any(wanted.gross_errors for wanted in chosen)
        injected = {entry["effect"] for wanted in chosen for entry in wanted.injected}
        assert injected > {"pose_jitter", "scan_bias", "unknown", "joint_harmonic"}
    assert len({wanted.seed for wanted in sets.sets.values()}) == 60


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("workcell: panda, seed: 3", "workcell: pandas, seed: 3", "unknown workcell 'pandas'"),
        ("name: nothing", "name: scale", "names an earlier set too"),
        ("sensor: tracker", "sensor: telescope", "telescope"),
        ("screening: 1", "screened: 1", "screened"),
    ],
)
def test_a_fault_in_the_config_is_named(tmp_path, old, new, says):
    """A misspelt name stops the study before anything runs."""
    text = (ROOT / "configs/sensitivity_smoke.yaml").read_text(encoding="utf-8")
    assert old in text
    path = tmp_path / "sets.yaml"
    path.write_text(text.replace(old, new), encoding="utf-8")
    with pytest.raises(InvalidInput, match=says):
        load_sets(path)


@pytest.mark.parametrize("sensor", ["tracker", "probe"])
def test_another_sensor_measures_the_same_arm(sensor):
    """With nothing injected, the rigid model explains the measurements of each sensor to their noise, less what the fit absorbs."""
    scene = {"poses_per_plane": 40, "noise.range_noise_std_m": NOISE, "truth_poses": 5}
    sets = Sets(scene, {"panda": {"scene": "configs/scenes/panda.yaml", "overrides": {}}}, 1, {})
    dataset, truth_poses = make_dataset(BlindSet("one", "panda", 5, sensor), sets, ROOT)
    assert dataset.sensor.kind == sensor and dataset.n_poses == 120
    calibration = calibrate(dataset)
    rows = 120 * (3 if sensor == "tracker" else 1)
    expected = NOISE * np.sqrt((1 - len(calibration.free) / rows) * (3 if sensor == "tracker" else 1))
    assert calibration.residual_rms == pytest.approx(
        expected, rel=4 / np.sqrt(2 * (rows - len(calibration.free)))
    )
    assert len(truth_poses) == 5


def test_a_setting_changes_an_answer_or_guards():
    """Every setting changes an answer in the committed table of the study, or is registered with a test in which it decides."""
    changed = TABLE[TABLE["changed_halved"] + TABLE["changed_doubled"] > 0]
    assert set(documentation(DEFAULTS)) - set(changed["setting"]) - set(GUARDS["setting"]) == set()


def test_a_guard_is_a_setting_and_its_test_is_there():
    """Each entry of the table of guards names a threshold and a test that exist."""
    known = documentation(DEFAULTS)
    for row in GUARDS.to_dict("records"):
        assert row["setting"] in known
        path, name = row["test"].split("::")
        assert f"def {name}(" in (ROOT / path).read_text(encoding="utf-8"), row["test"]
