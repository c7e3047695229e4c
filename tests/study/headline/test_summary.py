"""Summaries over seeds agree with the rows from which they are made."""

import numpy as np
import pandas as pd
import pytest
from study.headline.evaluate import ERROR_COLUMNS, PARAMETER_COLUMNS, PLANE_COLUMNS
from study.headline.summary import (
    QUANTITIES,
    place_published,
    summarise_errors,
    summarise_parameters,
    summarise_planes,
)


def errors_of(method: str, values: list[float], status: str = "converged") -> pd.DataFrame:
    """Return rows of errors.csv, one a value, all four quantities the same."""
    table = pd.DataFrame({quantity: values for quantity in QUANTITIES})
    table = table.assign(case="a", method=method, status=status, alignment="raw", seed=range(len(values)))
    return table.reindex(columns=list(ERROR_COLUMNS))


def test_a_failed_fit_is_counted_and_does_not_move_the_mean():
    """A row without numbers counts as a seed, as not converged and as without calibration."""
    good = errors_of("proposed", [1.0, 3.0])
    failed = errors_of("proposed", [float("nan")], status="undetermined").assign(seed=9)
    row = summarise_errors(pd.concat([good, failed], ignore_index=True)).iloc[0]
    assert (row["seeds"], row["not_converged"], row["without_calibration"]) == (3, 1, 1)
    assert (row["mean"], row["min"], row["max"]) == (2.0, 1.0, 3.0)


def test_the_initial_model_is_no_failure():
    """The initial model is not fitted, so it does not count as a fit that failed to converge."""
    row = summarise_errors(errors_of("initial", [1.0, 2.0], status="initial")).iloc[0]
    assert row["not_converged"] == 0


def test_the_order_of_rows_does_not_matter_to_a_summary():
    """Batches of any size give the same numbers."""
    rng = np.random.default_rng(3)
    table = errors_of("proposed", list(rng.random(20)))
    shuffled = table.sample(frac=1.0, random_state=1)
    pd.testing.assert_frame_equal(summarise_errors(table), summarise_errors(shuffled))


def test_published_values_fall_where_they_are_counted():
    """The percentile is the share of the seeds below the published value, separately for the initial and the calibrated models."""
    ours = pd.concat([errors_of("initial", [1, 2, 3, 4], "initial"), errors_of("proposed", [1, 2, 3, 4])])
    stated = pd.DataFrame({"state": ["initial", "calibrated"], **{q: [2.5, 9.0] for q in QUANTITIES}})
    placed = place_published(ours, stated).groupby("method")["percentile"].first()
    assert placed["initial"] == 50.0
    assert placed["proposed"] == 100.0


def test_unit_normal_errors_have_unit_spread():
    """Errors that are drawn with the stated standard errors have a normalised spread of 1, and 95 % of them are within 2."""
    rng = np.random.default_rng(7)
    std = 0.01
    error = std * rng.standard_normal(4000)
    table = pd.DataFrame({"error": error, "std": std, "normalized_error": error / std, "unit": "mm"})
    table = table.assign(case="a", method="proposed", parameter="a_2", truth=0.0, seed=range(4000))
    row = summarise_parameters(table.reindex(columns=list(PARAMETER_COLUMNS))).iloc[0]
    assert row["normalized_rms"] == pytest.approx(1.0, abs=0.05)
    assert row["within_2_std"] == pytest.approx(0.954, abs=0.015)
    assert row["error_rms"] == pytest.approx(row["std_mean"], rel=0.05)


def test_held_parameters_have_no_row():
    """A parameter that was not estimated has no row in the summary."""
    table = pd.DataFrame({"parameter": ["d_1"], "std": [np.nan], "case": "a", "method": "proposed"})
    assert summarise_parameters(table.reindex(columns=list(PARAMETER_COLUMNS))).empty


def test_a_plane_is_within_what_is_stated_in_both_figures_or_not():
    """A plane is within the published bounds only if both errors are; their signs do not count."""
    table = pd.DataFrame({"distance_error_mm": [-0.05, 0.05, 0.2], "normal_error_deg": [0.005, 0.02, 0.005]})
    table = table.assign(case="a", method="proposed", plane="floor").reindex(columns=list(PLANE_COLUMNS))
    stated = pd.DataFrame({"distance_error_mm": [0.1], "normal_error_deg": [0.01]})
    row = summarise_planes(table, stated).iloc[0]
    assert row["within_published"] == pytest.approx(1 / 3)
    assert row["distance_error_max_mm"] == 0.2
