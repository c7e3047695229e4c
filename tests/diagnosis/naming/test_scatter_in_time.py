"""A scatter from reading to reading is told from an error that is nearly the same in readings that follow each other."""

from types import SimpleNamespace

import numpy as np
import pytest

from scalar.diagnosis.naming.most_confidence import NOT_SURE, ONE_OF_TWO
from scalar.diagnosis.naming.scatter_in_time import (
    CORRELATION_LENGTHS,
    most_confidence_in_time,
    shares_in_time,
)
from tests.diagnosis.scattered import scattered

STD = 1e-4  # of the error of a reading [m]


@pytest.fixture
def campaign(monkeypatch):
    """Return a function that makes a stand-in for a state, and its component.

    Its arguments: the number of readings, the share of the variance that follows time, as a random walk pulled back over some five readings does, the
    seed, and whether the rows are in the order of acquisition.
    """

    def make(readings, smooth, seed, in_order=True):
        rng = np.random.default_rng(seed)
        walk, keep = [rng.normal()], np.exp(-1 / 5)
        for _ in range(readings - 1):
            walk.append(keep * walk[-1] + np.sqrt(1 - keep**2) * rng.normal())
        e = np.sqrt(smooth) * np.array(walk) + np.sqrt(1 - smooth) * rng.normal(size=readings)
        order = np.arange(readings) if in_order else rng.permutation(readings)
        return scattered(
            monkeypatch,
            rng,
            "scan_bias",
            STD * e[order][:, None],
            4e4,
            STD,
            known_poses=SimpleNamespace(order=order),
            q=np.arange(6.0 * readings).reshape(readings, 6),
        )

    return make


def test_of_a_random_error_nothing_follows_time(campaign):
    """Over sixty seeds the estimate has mean zero and the stated standard error."""
    ratios = []
    for seed in range(60):
        state, component = campaign(120, 0.0, seed)
        share, error = shares_in_time(state, component)[0]
        ratios.append(share / error)
    assert abs(np.mean(ratios)) < 3 / np.sqrt(60)
    assert 0.7 < np.std(ratios) < 1.3


@pytest.mark.parametrize("in_order", [True, False], ids=["rows by time", "rows shuffled"])
def test_an_error_that_follows_time_is_as_probably_no_scatter(campaign, in_order):
    """It is found by the order of acquisition, in whatever order the rows stand."""
    answers = [most_confidence_in_time(*campaign(120, 1.0, seed, in_order)) for seed in range(10)]
    assert sum(answer <= NOT_SURE for answer in answers) >= 9
    assert ONE_OF_TWO in answers


@pytest.mark.parametrize("readings", [40, 300, 900])
def test_a_random_error_keeps_its_name(campaign, readings):
    """Of any number of readings."""
    answers = [most_confidence_in_time(*campaign(readings, 0.0, seed)) for seed in range(10)]
    assert sum(answer == 1.0 for answer in answers) >= 8


def test_of_many_readings_runs_are_enough(campaign):
    """Where not all readings are looked at, those that are follow each other, so that an error that follows time is still seen."""
    assert most_confidence_in_time(*campaign(900, 1.0, 0)) < 1.0


def test_several_targets_of_one_stop_are_no_readings_that_follow_each_other(campaign):
    """Where the readings differ from their neighbours, nothing of what two targets of each stop have in common follows time."""
    state, component = campaign(40, 0.0, 5)
    state.dataset.q = np.zeros((40, 6))
    assert shares_in_time(state, component) == [(0.0, np.inf)] * len(CORRELATION_LENGTHS)
