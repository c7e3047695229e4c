"""The counts of halves in which one method or the other is ahead follow from the errors alone."""

from study.blind_trials.stratified_score import WORSE
from study.paper.measured_rivals import counts


def half(diagnosis, process=1.0, network=1.0, within=1.0):
    """Return the errors of one half, in units of what geometry leaves."""
    return {
        "geometry_mm": 1.0,
        "stated_mm": 2.0 * diagnosis,  # 1 with a diagnosis of 0.5
        "diagnosis_mm": diagnosis,
        "gaussian_process_mm": process,
        "network_mm": network,
        "geometry_within_mm": 1.0,
        "gaussian_process_within_mm": 1.0,
        "network_within_mm": 1.0,
        "diagnosis_within_mm": within,
    }


def test_halves_are_counted_by_a_stated_factor():
    """A method is ahead, behind or harmful only by more than the factor, and the better learner is what the diagnosis is compared with."""
    sets = {
        "one": {"halves": [half(0.5), half(WORSE + 0.01, within=WORSE - 0.01)]},
        "two": {
            "halves": [
                half(0.5, network=0.5 * WORSE - 0.01),
                half(0.5, process=0.4, network=WORSE + 0.01, within=WORSE + 0.01),
            ]
        },
    }
    assert counts(sets) == {
        "campaigns": 2,
        "halves": 4,
        "ahead": 1,
        "ahead_within": 0,
        "behind": 2,
        "behind_within": 1,
        "behind_sets": ["one", "two"],
        "harmful": 1,
        "harmful_within": 1,
        "learned_harmful": 1,
        "learned_nothing": 2,
        "stated_too_small": 1,
        "stated_mm": {"least": 1.0, "greatest": 2.0 * (WORSE + 0.01)},
    }
