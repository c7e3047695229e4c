"""The comparison of planned and random poses: its numbers for a table whose ratios are known."""

import pandas as pd
import pytest
from study.planning.compare import PLANNED, RANDOM
from study.planning.summary import planning_numbers, summarise_planning


def table(ratio):
    """Return errors of ten seeds in which planned poses err ``ratio`` times as much, and one seed that failed."""
    rows = []
    for seed in range(10):
        for way, times in ((RANDOM, 1.0), (PLANNED, ratio)):
            error = times * (1.0 + 0.1 * seed)
            rows.append(
                {"seed": seed, "way": way, "poses": 30, "status": "calibrated", "expected_error_mm": error,
                 "position_mean_mm": error, "position_max_mm": 2 * error, "position_rms_mm": error}
            )  # fmt: skip
    rows.append({"seed": 10, "way": PLANNED, "poses": 30, "status": "Undetermined"})
    return pd.DataFrame(rows)


@pytest.mark.parametrize("ratio", [0.5, 2.0])
def test_ratios_are_taken_in_the_same_seed(ratio):
    """Ratios are of the same seed: their median, the number of seeds in which planning is better, and what chance makes of that number."""
    entry = planning_numbers(table(ratio))["planned_30_against_random_30"]
    assert entry["times_random"] == pytest.approx(ratio)
    assert entry["better_in"] == (10 if ratio < 1 else 0)
    assert entry["p_value"] == pytest.approx(2.0**-9)


def test_failures_are_counted_and_left_out():
    """A seed that could not be calibrated is counted as failed, and enters no median."""
    summary = summarise_planning(table(0.5)).set_index("way")
    assert summary.loc[PLANNED, "failed"] == 1
    assert summary.loc[PLANNED, "position_mean_mm_median"] == pytest.approx(0.725)
    assert summary.loc[RANDOM, "failed"] == 0
