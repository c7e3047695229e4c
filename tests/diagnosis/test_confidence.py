"""The share of the evidence that speaks for an answer, soberly."""

import math

import pytest

from scalar.diagnosis.confidence import MOST, SOBERNESS, confidence


def test_two_that_explain_the_same_share_it():
    """Far from nothing at all, each of two equals is right every other time."""
    assert confidence(80.0, [80.0]) == pytest.approx(MOST / 2)


def test_rivals_add_up():
    """Three rivals as good as one another speak against an answer as one does that is better by log 3."""
    assert confidence(80.0, [75.0] * 3) == pytest.approx(confidence(80.0, [75.0 + math.log(3)]))


def test_against_nothing_at_all_it_is_the_logistic_of_the_evidence():
    """With no rival the odds are those of the evidence, which counts for less than it says."""
    for nats in (-3.0, 0.0, 2.0):
        assert confidence(nats, []) == pytest.approx(MOST / (1 + math.exp(-nats / SOBERNESS)))


def test_no_answer_is_surer_than_such_answers_have_been():
    """However large the evidence, and however small a rival's."""
    assert confidence(1e6, [-math.inf, -1e6]) == MOST < 1.0
    assert confidence(-1e6, [1e6]) == 0.0
