"""What a confidence means: a chance, the smaller the better the rivals, and as often right as it says."""

import math
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scalar.diagnosis.confidence import confidence
from scalar.diagnosis.settings import ConfidenceSettings

SUMMARIES = Path(__file__).parents[2] / "paper/summaries/blind_trials"
nats = st.floats(-200.0, 200.0)


@given(own=nats, others=st.lists(nats, max_size=5))
def test_it_is_a_chance(own, others):
    """Never below zero, never above the share of sure answers that have been right, whatever the evidence."""
    assert 0.0 <= confidence(own, others) <= ConfidenceSettings().most < 1.0


@given(own=nats, more=st.floats(0.0, 50.0), others=st.lists(nats, min_size=1, max_size=5))
def test_evidence_for_it_raises_it_and_evidence_for_a_rival_lowers_it(own, more, others):
    """It never falls with its own evidence, and never rises with a rival's, nor with one rival more."""
    now = confidence(own, others)
    assert confidence(own + more, others) >= now
    assert confidence(own, [others[0] + more, *others[1:]]) <= now
    assert confidence(own, [*others, own - more]) <= now


@given(own=nats, others=st.lists(nats, min_size=2, max_size=5), seed=st.integers(0, 1000))
def test_the_order_of_the_rivals_does_not_matter(own, others, seed):
    """Rivals are a set."""
    shuffled = list(np.random.default_rng(seed).permutation(others))
    assert confidence(own, shuffled) == pytest.approx(confidence(own, others), rel=1e-12, abs=1e-300)


def test_of_two_equals_neither_is_likelier():
    """Far from nothing at all, each of two equals gets half of what an answer without a rival gets."""
    assert confidence(500.0, [500.0]) == pytest.approx(confidence(500.0, []) / 2)


def test_no_evidence_at_all_is_no_confidence():
    """Where everything else explains far better, the chance is nil."""
    assert confidence(-1e6, [1e6]) == 0.0
    assert confidence(5.0, [-math.inf]) == confidence(5.0, [])


def test_answers_have_been_right_as_often_as_their_confidence_says():
    """Reliability over the committed blind trials: in every bin of confidence the share of right answers is the mean
    confidence, to within four standard errors of the share.
    """
    table = pd.read_csv(SUMMARIES / "reliability.csv").query("by == 'confidence'")
    assert table["answers"].sum() > 500
    for row in table.itertuples():
        error = math.sqrt(row.mean_stated * (1 - row.mean_stated) / row.answers)
        assert abs(row.right_share - row.mean_stated) < 4 * error, row


def test_a_name_beside_unmodelled_structure_is_no_sure_answer():
    """However much evidence it has: it may be a part of that structure."""
    assert confidence(500.0, [], beside_unmodelled=True) < 0.8 < confidence(500.0, [])
