"""The share of the evidence that speaks for an answer."""

import math

import pytest

from scalar.diagnosis.confidence import MOST, confidence


def test_two_that_explain_the_same_share_it():
    """Far from nothing at all, each of k equals is right in one of k."""
    for k in (2, 3, 5):
        assert confidence(80.0, [80.0] * (k - 1)) == pytest.approx(MOST / k)


def test_against_nothing_at_all_it_is_the_logistic_of_the_evidence():
    """With no rival the odds are those of the evidence."""
    for nats in (-3.0, 0.0, 2.0):
        assert confidence(nats, []) == pytest.approx(MOST / (1 + math.exp(-nats)))


def test_no_answer_is_surer_than_such_answers_have_been():
    """However large the evidence, and however small a rival's."""
    assert confidence(1e6, [-math.inf, -1e6]) == MOST < 1.0
    assert confidence(-1e6, [1e6]) < 1e-300
