"""The confidence of an answer: a probability that grows with the evidence, and is right as often as it states on sets to which it was not fitted."""

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.special import expit
from study.confidence.answers import HALVES
from study.confidence.fit import (
    FEATURES,
    KINDS,
    by_poses,
    fitted,
    regression,
    reliability,
    reliability_by_poses,
    summary,
    with_confidence,
)

from scalar.diagnosis.naming.confidence import COEFFICIENTS, confidence, features, logistic_probability
from scalar.diagnosis.naming.grounds import FinalResiduals, Grounds, log_odds

SUMMARIES = Path(__file__).parents[3] / "paper/summaries/confidence"
SHIPPED = Path(__file__).parents[3] / "scalar/diagnosis/naming" / COEFFICIENTS
nats = st.floats(-200.0, 200.0)
shares = st.floats(0.0, 1.0)
left = st.builds(
    FinalResiduals,
    st.integers(2, 100_000),
    st.floats(1e-3, 1e4),
    st.floats(1e-30, 1.0),
    st.booleans(),
    st.booleans(),
)
names = st.sampled_from(["joint_harmonic", "pose_jitter", "unattributed", "an effect of a user"])
grounds = st.builds(
    Grounds,
    st.sampled_from(KINDS),
    nats,
    nats,
    shares,
    st.integers(0, 40),
    st.booleans(),
    st.booleans(),
    left,
)


@given(own=nats, more=st.floats(0.0, 50.0), others=st.lists(nats, min_size=1, max_size=5))
def test_evidence_for_an_answer_raises_its_odds_and_evidence_for_a_rival_lowers_them(own, more, others):
    """The log odds never fall with the answer's own evidence, and never rise with a rival's evidence or with one more rival."""
    now = log_odds(own, others)
    assert log_odds(own + more, others) >= now
    assert log_odds(own, [others[0] + more, *others[1:]]) <= now
    assert log_odds(own, [*others, own - more]) <= now


@given(own=nats, others=st.lists(nats, min_size=2, max_size=5), seed=st.integers(0, 1000))
def test_the_order_of_the_rivals_does_not_matter(own, others, seed):
    """The log odds are the same for every order of the rivals."""
    shuffled = list(np.random.default_rng(seed).permutation(others))
    assert log_odds(own, shuffled) == pytest.approx(log_odds(own, others), rel=1e-12, abs=1e-12)


def test_of_two_equals_neither_is_likelier():
    """Two answers with the same large evidence have even odds each; without a rival, the odds are those against no effect."""
    assert log_odds(500.0, [500.0]) == pytest.approx(0.0)
    assert log_odds(5.0, []) == pytest.approx(5.0) == log_odds(5.0, [-math.inf])


@given(grounds=grounds, name=names)
def test_a_confidence_is_a_probability(grounds, name):
    """It lies between 0 and 1, whatever the grounds and the name."""
    assert 0.0 <= confidence(grounds, name) <= 1.0


@given(grounds=grounds, name=names, more=st.floats(0.0, 100.0))
def test_more_evidence_never_lowers_the_confidence(grounds, name, more):
    """With larger log odds, or larger least log odds, and all other grounds the same, the confidence is at least as large."""
    likelier = replace(grounds, log_odds=grounds.log_odds + more)
    steadier = replace(grounds, least_log_odds=grounds.least_log_odds + more)
    assert min(confidence(likelier, name), confidence(steadier, name)) >= confidence(grounds, name)


@given(grounds=grounds, name=names)
def test_grounds_outside_the_trials_count_as_the_nearest_in_them(grounds, name):
    """A feature outside the range of the trials is replaced by the nearest end of that range."""
    tried = json.loads(SHIPPED.read_text(encoding="utf-8"))[grounds.kind]
    values = features(grounds)
    nearest = {
        name: min(max(values[name], entry["from"]), entry["to"]) for name, entry in tried["features"].items()
    }
    assert logistic_probability(values, name, tried) == logistic_probability(nearest, name, tried)


def test_a_regression_finds_the_coefficients_of_simulated_answers():
    """From 20,000 answers drawn with known odds, the coefficients are found within four standard errors, at most 0.1."""
    rng = np.random.default_rng(4)
    X = rng.normal(size=(20_000, len(FEATURES))) * np.linspace(0.5, 2.0, len(FEATURES)) + 1.0
    signs = {"log_odds": 2.5, "least_log_odds": 1, "rivalled": -1, "share": 1}  # which coefficients keep
    truth = np.array([0.3 * signs.get(name, (-1) ** k) for k, name in enumerate(FEATURES)])
    right = (rng.random(len(X)) < expit(X @ truth - 0.5)).astype(float)
    found = regression(X, right, ["one"] * len(X), 1.0)
    slopes = [found["features"][name]["coefficient"] for name in FEATURES]
    np.testing.assert_allclose(slopes, truth, atol=0.2)
    assert found["intercept"] == pytest.approx(-0.5, abs=0.3)


def test_evidence_that_speaks_against_an_answer_is_ignored():
    """If answers with more evidence were right less often in the trials, the coefficient is zero, because that is an artefact of few answers."""
    rng = np.random.default_rng(5)
    X = np.zeros((400, len(FEATURES)))
    X[:, 0] = rng.normal(size=400)
    right = (rng.random(400) < expit(-X[:, 0])).astype(float)
    assert regression(X, right, ["one"] * len(X), 1.0)["features"][FEATURES[0]]["coefficient"] == 0.0


def test_a_name_that_is_wrong_more_often_has_less_confidence():
    """On the same grounds, one name is right in nine of ten answers and another in six; these are their confidences, and a name never given lies
    between.
    """
    X = np.zeros((2000, len(FEATURES)))
    given_names = ["often right"] * 1000 + ["often wrong"] * 1000
    right = np.r_[np.arange(1000) < 900, np.arange(1000) < 600].astype(float)
    found = regression(X, right, given_names, 1.0)
    grounds_alike = dict.fromkeys(FEATURES, 0.0)
    chance = {
        name: logistic_probability(grounds_alike, name, found)
        for name in ("often right", "never given", "often wrong")
    }
    assert chance["often right"] == pytest.approx(0.9, abs=0.01)
    assert chance["often wrong"] == pytest.approx(0.6, abs=0.01)
    assert chance["often wrong"] < chance["never given"] < chance["often right"]


@pytest.fixture(scope="module")
def answers():
    """Return the committed answers of the trials."""
    return pd.read_csv(SUMMARIES / "answers.csv", keep_default_na=False)


def test_the_shipped_coefficients_are_those_that_the_committed_answers_give(answers):
    """A new fit gives the same probabilities to 1e-3, and so do the fits to each half of the answers, applied to the other half."""
    again, shipped = fitted(answers), json.loads(SHIPPED.read_text(encoding="utf-8"))
    for row in answers.to_dict("records"):
        chance = logistic_probability(row, row["name"], shipped[row["kind"]])
        assert logistic_probability(row, row["name"], again[row["kind"]]) == pytest.approx(chance, abs=1e-3)
    np.testing.assert_allclose(with_confidence(answers)["confidence"], answers["confidence"], atol=1e-3)


def test_no_set_and_no_unknown_cause_is_in_both_halves(answers):
    """Each set of a trial lies in one half, so that no probability is reported for an answer to which the regression was fitted."""
    halves = answers.groupby(["number", "seed"])["half"].nunique()
    assert halves.max() == 1
    assert set(answers["half"]) == set(HALVES)


def test_answers_have_been_right_as_often_as_the_fit_to_the_other_half_says():
    """In every bin with answers, the share of right answers agrees with the stated confidence within four standard errors."""
    table = pd.read_csv(SUMMARIES / "reliability.csv").query("answers > 0")
    assert table["answers"].sum() > 100
    for row in table.to_dict("records"):
        stated, answers = row["mean_stated"], row["answers"]
        error = math.sqrt(max(stated * (1 - stated), 0.25 / answers) / answers)
        assert abs(row["share"] - stated) < 4 * error, row


def test_every_answer_is_counted_under_its_number_of_poses(answers):
    """The classes of numbers of poses divide the answers, their tables add up to the whole one, and answers of 60 and of 61 poses are apart."""
    committed = pd.read_csv(SUMMARIES / "reliability_by_poses.csv")
    whole = reliability(answers).set_index(["kind", "from"])
    parts = reliability_by_poses(answers)
    for key in ("answers", "right"):
        assert parts.groupby(["kind", "from"])[key].sum().to_dict() == whole[key].to_dict()
        assert list(committed[key]) == list(parts[key])
    one = answers.iloc[[0]]
    some = pd.concat([one.assign(poses=math.log(n / 100)) for n in (21, 60, 61, 120, 121, 3000)])
    assert [len(part) for part in by_poses(some).values()] == [2, 2, 2]


def test_the_committed_numbers_are_those_of_the_committed_answers(answers):
    """The numbers that the paper quotes follow from the committed table of answers."""
    committed = json.loads((SUMMARIES / "numbers.json").read_text(encoding="utf-8"))
    for key, value in summary(answers).items():
        if isinstance(value, dict):
            assert committed[key] == pytest.approx(value, rel=1e-6, nan_ok=True)
        else:
            assert committed[key] == value
