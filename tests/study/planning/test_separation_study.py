"""Whether further poses separate confounded causes: the bound on what poses can do, what counts as separated, and the shares."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from study.planning.bound import best_noncentrality
from study.planning.separate import distinguished, first_of_each_plane, named_alone
from study.planning.separation_summary import WAYS, separation_numbers

from scalar.planning.separation import Question, noncentralities, separating_poses


def problem(seed):
    """Return a question, the information of the measured poses, and the rows of 40 candidates."""
    rng = np.random.default_rng(seed)
    rows = rng.standard_normal((40, 2, 5)) * rng.uniform(0.1, 2.0, (40, 1, 1))
    return Question("q", np.array([3, 4]), np.array([0, 1, 2]), np.array([1.0, -0.5])), 0.1 * np.eye(5), rows


@pytest.mark.parametrize("seed", range(4))
def test_no_poses_exceed_the_bound(seed):
    """Neither planned poses nor a thousand random choices exceed the bound, and the planned ones come close to it."""
    question, start, rows = problem(seed)
    bound = best_noncentrality(question, start, rows, 6)
    rng = np.random.default_rng(seed)
    tried = [
        noncentralities([question], start, rows[rng.choice(40, 6, replace=False)])[0] for _ in range(1000)
    ]
    _, (answer,) = separating_poses([question], start, rows, 6)
    assert max(tried) <= answer.planned * 1.2 and answer.planned <= bound * (1 + 1e-9)
    assert answer.planned > 0.8 * bound


def test_with_all_candidates_the_bound_is_what_they_give():
    """With all candidates chosen, the bound equals the noncentrality that they give."""
    question, start, rows = problem(7)
    assert best_noncentrality(question, start, rows, 40) == pytest.approx(
        noncentralities([question], start, rows)[0]
    )


def effect(name, joint):
    """Return an object with the name and target of an effect."""
    return SimpleNamespace(name=name, target={"joint": joint})


def test_a_pair_is_distinguished_unless_the_other_cause_is_listed():
    """A pair is distinguished if one is named alone, both are found, or something else is.

    It is not if nothing is found, the other is listed, or the diagnosis failed.
    """
    pair = SimpleNamespace(effect=effect("a", 1), rival=effect("b", 2))
    a, b = ({"name": e.name, "target": e.target, "confounded_with": []} for e in (pair.effect, pair.rival))
    other = {"name": "c", "target": {}, "confounded_with": [{"name": "b", "target": {"joint": 2}}]}
    for effects in ([a], [b], [a, b], [other]):
        assert distinguished(pair, effects)
    listed = a | {"confounded_with": [{"name": "b", "target": {"joint": 2}}]}
    reverse = b | {"confounded_with": [{"name": "a", "target": {"joint": 1}}]}
    for effects in ([], [listed], [other, reverse], None):
        assert not distinguished(pair, effects)
    assert named_alone({"name": "a", "target": {"joint": 1}}, [a, b])
    assert not named_alone({"name": "a", "target": {"joint": 1}}, [listed])


def test_the_first_poses_of_each_plane_are_taken():
    """The same number of poses is taken of each plane, the first ones in the order of acquisition."""
    plane = np.array([1, 0, 0, 1, 0, 1])
    assert first_of_each_plane(plane, 2).tolist() == [0, 1, 2, 3]


def test_shares_are_of_pairs_that_poses_can_separate():
    """Sets without pairs and pairs beyond any poses, or separated already, are counted and are in no share."""
    base = {
        "case": "c",
        "workcell": "w",
        "size": 1.0,
        "pairs": 1,
        "now": 1.0,
        "separable": True,
        "separable_by_all": True,
    }
    hits = dict.fromkeys(WAYS.values(), False)
    rows = [base | hits | {"seed": k, "separated": k < 3} for k in range(4)]
    rows.append(base | hits | {"seed": 5, "separable": False})
    rows.append(base | hits | {"seed": 6, "now": 9.0, "separated": True})
    rows.append({"case": "c", "workcell": "w", "size": 1.0, "seed": 7, "pairs": 0})
    numbers = separation_numbers(pd.DataFrame(rows))
    assert (numbers["sets"], numbers["sets_with_pairs"], numbers["pairs"]) == (7, 6, 6)
    assert numbers["separable"]["pairs"] == 4 and numbers["separable_by_all"]["pairs"] == 5
    share = numbers["separable"]["expected_planned"]
    assert share["share"] == 0.75 and share["low"] < 0.75 < share["high"]
