"""Trials with the outer split: half of the poses are measured, stated errors are held against true ones, and refused names are counted."""

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest
from study.blind_trials.outer_split import SPLIT_COLUMNS, seen_poses
from study.blind_trials.outer_split_summary import split_numbers, split_rates
from study.blind_trials.stratified_design import Design, load_design
from study.blind_trials.stratified_run import TRIAL_COLUMNS, run_trials

ROOT = Path(__file__).parents[3]
SMOKE = ROOT / "configs/blind_trials_stratified_smoke.yaml"
GEAR = {"name": "joint_harmonic", "target": {"joint": 2, "orders": [2]}, "confidence": 0.9}
SCALE = {"name": "joint_scale", "target": {"joint": 4}, "confidence": 0.9}
CAUSE = {"name": "joint_harmonic", "target": {"joint": 2, "order": 2}, "kind": None, "size": 1e-4}


def one_set(found, found_split, not_confirmed=(), stated=1.0, true=1.0):
    """Return the row of a set in which joint 2 has a gear error."""
    return {
        "row": "one effect, ideal",
        "injected": json.dumps([CAUSE]),
        "scanner_truth": "null",
        "surface_truth": "null",
        "unobservable": "[]",
        "status": "diagnosed",
        "status_split": "diagnosed",
        "found": json.dumps(found),
        "found_split": json.dumps(found_split),
        "not_confirmed": json.dumps(list(not_confirmed)),
        "held_out_stated_mm": 1.0,
        "held_out_true_mm": 2.0,
        "unseen_stated_mm": stated,
        "unseen_true_mm": true,
        **{f"position_{when}_mm": 1.0 for when in ("before", "after", "after_split", "floor", "told")},
    }


@pytest.fixture(scope="module")
def sets():
    """Return a set whose wrong name the split refuses, one whose right name it refuses, and one in which nothing is refused."""
    yes, no = {"selected_in": 0.8}, {"selected_in": 0.2}
    return pd.DataFrame(
        [
            one_set([GEAR, SCALE], [GEAR | yes], [SCALE | no], 1.0, 1.05),
            one_set([GEAR], [], [GEAR | no], 1.0, 0.9),
            one_set([GEAR, SCALE], [GEAR | yes, SCALE | yes], [], 1.0, 1.4),
        ]
    )


def test_rates_are_those_of_both_diagnoses(sets):
    """Wrong names: two sets without the split and one with it. Clean: one set each; with the split, the right name of another is missed."""
    table = split_rates(sets)
    counts = table[table["row"] == "all"].set_index(["rate", "split"])["count"]
    assert (counts["wrong", 0], counts["wrong", 1]) == (2, 1)
    assert (counts["clean", 0], counts["clean", 1]) == (1, 1)
    assert (counts["missed", 0], counts["missed", 1]) == (0, 1)


def test_errors_are_held_against_the_true_ones(sets):
    """One of three stated errors covers the true one, two do within a tenth; those of held-out poses cover none."""
    numbers = split_numbers(sets)
    assert (numbers["unseen"]["covered"], numbers["unseen"]["covered_within_a_tenth"]) == (1, 2)
    assert numbers["unseen"]["true_over_stated_50"] == pytest.approx(1.05)
    assert numbers["held_out"]["covered"] == 0 and numbers["held_out"]["sets"] == 3


def test_refused_names_are_counted_by_whether_they_are_right(sets):
    """Of two wrong names the split refuses one, and of three right ones another; a set that was not diagnosed does not count."""
    failed = sets.iloc[[0]].assign(status_split="Undetermined")
    numbers = split_numbers(pd.concat([sets, failed]))
    assert numbers["sets"] == 3
    assert numbers["wrong_names"] == {"names": 2, "not_confirmed": 1}
    assert numbers["right_names"] == {"names": 3, "not_confirmed": 1}


def test_half_of_the_poses_of_each_plane_are_measured():
    """Each plane has as many unseen poses as measured ones, and another seed measures others."""
    planes = pd.DataFrame({"plane": ["floor", "wall", "back"] * 20})
    simulated: Any = SimpleNamespace(poses=planes)
    seen = seen_poses(simulated, 3)
    assert planes["plane"][seen].value_counts().to_dict() == {"floor": 10, "wall": 10, "back": 10}
    assert not np.array_equal(seen, seen_poses(simulated, 4))


@pytest.mark.slow
def test_a_small_run_states_and_finds_errors_at_unseen_poses():
    """A set of the small design is diagnosed without and with two parts, has all columns, and the true error is that of other poses."""
    design = load_design(SMOKE)
    small = Design(design.content | {"outer_split": 2})
    (trial,) = run_trials(small, range(1), ROOT).to_dict("records")
    assert list(trial) == [*TRIAL_COLUMNS, *SPLIT_COLUMNS]
    assert trial["status"] == trial["status_split"] == "diagnosed"
    assert 0.3 < trial["unseen_true_mm"] / trial["unseen_stated_mm"] < 3.0
    assert trial["unseen_true_mm"] != trial["held_out_stated_mm"]
