"""What a diagnosis of a tracked trial says is judged: right and wrong names, what cannot be seen, and corrections that do harm."""

import pytest
from study.tracked_trials.score import RATES, tracked_score

from tests.study.tracked_trials.causes import cause


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
