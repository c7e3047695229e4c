"""The answers of trials: which half they belong to, and which of them are right."""

import json

import pandas as pd
import pytest
from study.confidence.answers import HALVES, tracked_answers_of

GROUNDS = {
    "log_odds": 9.0,
    "least_log_odds": 8.0,
    "share": 0.5,
    "others": 0,
    "beside_structure": False,
    "structure_there": False,
    "poses": 100,
    "misfit": 1.0,
    "chance": 0.3,
    "correlated": False,
    "scans": False,
}
SCALE = {"name": "joint_scale", "target": {"joint": 2}}
GEAR = {"name": "joint_harmonic", "target": {"joint": 4, "orders": [2, 5]}}
JITTER = {"name": "pose_jitter", "target": {}}


def answers(found, causes, repeatability=0.0, number=3):
    """Return the answers of one set of a tracker."""
    entries = [entry | {"grounds": GROUNDS, "confidence": 0.9} for entry in found]
    row = {"number": number, "seed": 1, "sensor": "tracker", "poses": 100, "repeatability_rad": repeatability}
    return tracked_answers_of(
        pd.DataFrame([row | {"injected": json.dumps(causes), "found": json.dumps(entries)}])
    )


def test_a_name_is_right_if_it_is_a_cause_at_its_place():
    """A gear error is right even with a further order; a scale error of another joint is wrong."""
    causes = [{"name": "joint_harmonic", "target": {"joint": 4, "order": 2}}]
    assert list(answers([GEAR, SCALE], causes)["right"]) == [True, False]


@pytest.mark.parametrize(("repeatability", "right"), [(0.0, False), (2e-5, True)])
def test_a_jitter_is_right_where_joints_do_not_come_back(repeatability, right):
    """A jitter of poses is right if the joints do not return exactly to a pose, and wrong otherwise."""
    assert list(answers([JITTER], [], repeatability)["right"]) == [right]


def test_structure_is_right_where_a_cause_has_no_name():
    """Unattributed structure is right if a cause is not named, and wrong if all causes are."""
    structure = {"name": "unattributed", "target": {}, "most_like": []}
    causes = [SCALE, {"name": "unknown", "target": {"joint": 1}}]
    assert list(answers([SCALE, structure], causes)["right"]) == [True, True]
    assert list(answers([SCALE, structure], causes[:1])["right"]) == [True, False]


def test_a_doubtful_name_counts_as_an_answer_with_its_own_grounds():
    """An entry that only lists doubtful names is replaced by these names as answers; the number of the set decides its half."""
    gathered = {"name": "unattributed", "target": {}, "most_like": [SCALE | {"grounds": GROUNDS}]}
    found = answers([gathered], [SCALE], number=4)
    assert list(found["name"]) == ["joint_scale"] and list(found["kind"]) == ["effect"]
    assert list(found["half"]) == [HALVES[0]] and list(found["scans"]) == [0.0]
