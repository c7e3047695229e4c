"""Sets of sealed exams in which a diagnosis went wrong, taken once more: what was mended stays mended."""

import json
import re
from pathlib import Path

import pytest

pytest.importorskip("pybullet")
from study.blind_trials.score import same
from study.blind_trials.stratified_design import Design, load_design
from study.blind_trials.stratified_run import run_trial

ROOT = Path(__file__).parents[3]


def answered(seed: int, number: int) -> dict:
    """Return the row of one set of the exam with this seed."""
    content = load_design(ROOT / "configs" / "blind_trials_sealed.yaml").content
    design = Design({**content, "seed": seed, "sets": 640})
    return run_trial(design, design.trials(number + 1)[number], ROOT)


def test_scans_are_not_shrunk_to_a_point_when_an_effect_is_dropped():
    """Without the slip, which had been found, a range that shrinks by 99 % left no residual: 0.75 mm had become 222 mm (fourteenth exam)."""
    row = answered(1684053431, 633)
    assert {entry["name"] for entry in json.loads(row["injected"])} >= {"sensor_slip", "range_distortion"}
    assert row["position_after_mm"] < row["position_before_mm"]
    assert {"sensor_slip", "range_distortion", "joint_scale"} <= {
        entry["name"] for entry in json.loads(row["found"])
    }


@pytest.mark.slow
@pytest.mark.parametrize(("number", "left_mm"), [(411, 0.1), (632, 0.1)])
def test_what_is_overwhelming_is_found_among_few_poses(number, left_mm):
    """Four and five effects among sixty poses: 5.5 and 1.3 mm had been left, because held-out errors did not fall clearly (fourteenth exam)."""
    row = answered(1684053431, number)
    found = json.loads(row["found"])
    assert all(any(same(entry, effect) for entry in found) for effect in json.loads(row["injected"]))
    assert row["position_after_mm"] < left_mm < 1.0 < row["position_before_mm"]


@pytest.mark.slow
def test_bows_of_all_plates_are_found_together():
    """Each of two further bows had been absorbed by the geometry, and a compliance of two joints with them (fourteenth exam)."""
    row = answered(1684053431, 215)
    found = json.loads(row["found"])
    assert {"floor", "wall_x", "wall_y"} == {e["target"]["plane"] for e in found if e["name"] == "plane_bow"}
    assert all(any(same(entry, effect) for entry in found) for effect in json.loads(row["injected"]))


@pytest.mark.slow
def test_a_doubtful_change_of_the_last_poses_is_not_applied_to_all_later_ones():
    """A supposed slip before the last 6 of 300 poses had turned an error of 0.039 mm into 0.551 mm (fifteenth exam)."""
    row = answered(1121107210, 326)
    assert row["position_after_mm"] < row["position_before_mm"]


@pytest.mark.parametrize("path", ["configs/blind_trials_stratified.yaml", "docs/many_machines.md"])
def test_the_stated_time_of_a_set_is_that_of_the_committed_run(path):
    """What a set of 60 to 300 poses takes is stated as the committed run of the trials measured it, within a third."""
    numbers = json.loads((ROOT / "paper/summaries/stratified/numbers.json").read_text("utf-8"))
    measured = numbers["simulate_s_mean"] + numbers["diagnose_s_mean"]
    stated = [float(text) for text in re.findall(r"([\d.]+) s a set", (ROOT / path).read_text("utf-8"))]
    assert stated and all(0.67 < value / measured < 1.5 for value in stated)
