"""Numbers of the sweeps: slopes, edges and ratios of tables that were made to have them."""

import numpy as np
import pandas as pd
import pytest
from study.common.statistics import QUANTITIES
from study.sweeps.numbers import join_placed, sweep_numbers
from study.sweeps.summary import PLACED_COLUMNS, place_published_curve

SEEDS = 6


def table_of(values, error_at, methods=("proposed",), status_at=lambda value, seed: "converged"):
    """Return errors.csv of a sweep: every quantity is error_at(value, seed)."""
    rows = []
    for value in values:
        for seed in range(SEEDS):
            bound = ("cramer-rao", "efficient") if value > 0 else ()  # without noise there is none
            for method in (*bound, *methods):
                status = status_at(value, seed) if method in methods else method
                error = error_at(value, seed) if status in ("converged", method) else np.nan
                rows.append(
                    {"walls": "upright", "case": f"at-{value:g}", "value": value, "seed": seed}
                    | {"method": method, "status": status, "alignment": "raw"}
                    | dict.fromkeys(QUANTITIES, error)
                )
    return pd.DataFrame(rows)


def numbers_of(**sweeps):
    """Return the numbers of sweeps without published points."""
    placed = {name: pd.DataFrame(columns=PLACED_COLUMNS) for name in sweeps}
    return sweep_numbers(sweeps, placed, dict.fromkeys(sweeps, "axis [unit]"))


@pytest.mark.parametrize("power", [1.0, 0.5])
def test_the_slope_is_the_power_of_the_noise(power):
    """Errors that are a power of the noise have that slope; noise zero has none and is left out."""
    noises = [0.0, 1e-3, 1e-2, 1e-1]
    table = table_of(noises, lambda value, seed: 0.2 * value**power * (1 + 0.1 * seed))
    slope = numbers_of(noise=table)["noise_slope"]["upright"]["proposed"]
    assert slope["slope"] == pytest.approx(power)
    assert (slope["from_mm"], slope["to_mm"]) == (1e-3, 1e-1)
    assert slope["error_over_noise_max"] / slope["error_over_noise_min"] == pytest.approx(100 ** (1 - power))


def test_the_edge_is_the_last_value_at_which_every_seed_succeeds():
    """One fit that is lost, far from the truth, ends the range, even if all seeds succeed at values beyond."""
    table = table_of([10, 20, 30, 40], lambda value, seed: 99.0 if value == 30 and seed == 2 else 0.02)
    edge = numbers_of(plane_tilt=table)["edges"]["plane_tilt"]["upright"]["proposed"]
    assert (edge["all_succeed_up_to"], edge["first_failure_at"], edge["none_succeeds_from"]) == (20, 30, None)
    assert edge["succeeded"] == {"10": 6, "20": 6, "30": 5, "40": 6}


def test_failures_are_counted_once_and_are_no_successes():
    """Refused, raised and capped fits are counted once, each by its kind, and none as a success."""
    kinds = ["converged", "refused", "raised", "capped", "converged", "converged"]
    table = table_of([1.0], lambda value, seed: 0.02, status_at=lambda value, seed: kinds[seed])
    ends = numbers_of(points=table)["failures"]["upright"]["proposed"]
    assert (ends["seeds"], ends["succeeded"], ends["failed"]) == (6, 3, 3)
    assert (ends["raised"], ends["capped"]) == (1, 1)


def test_errors_equal_to_the_bound_have_a_ratio_of_one():
    """The ratio is one, and what has no sweep in a run has no answer."""
    numbers = numbers_of(noise=table_of([0.1, 1.0], lambda value, seed: value * (1 + seed)))
    near = numbers["near_bound"]["proposed"]
    assert near["points"] == near["within_10_percent_of_efficient"] == near["within_10_percent_of_bound"] == 2
    assert near["over_bound_median"] == near["over_efficient_worst"] == pytest.approx(1.0)
    assert numbers["enough"] == {}
    assert numbers["published_inside"]["points"] == 0


def test_what_is_enough_is_a_ratio_of_mean_errors():
    """The ratio is the mean error at the first value divided by that at the second."""
    table = table_of([20.0, 100.0], lambda value, seed: 3.0 / value**0.5)
    found = numbers_of(points=table)["enough"]["points"]["walls"]["upright"]["proposed"]
    assert found["position_mean_mm"] == pytest.approx(5**0.5)


def test_published_values_are_counted_point_by_point():
    """Published values inside, below and above the band add up to all of them, for each sweep and for all."""
    table = table_of([1.0, 2.0], lambda value, seed: value + 0.1 * seed)
    curve = pd.DataFrame([{"value": v, **dict.fromkeys(QUANTITIES, 1.25)} for v in (1.0, 2.0)])
    placed = {"noise": place_published_curve(table, curve)}
    counts = sweep_numbers({"noise": table}, placed, {"noise": "x"})["published_inside"]
    of = counts["walls"]["upright"]["proposed"]
    assert (counts["points"], counts["values"], of["values"]) == (2, 8, 8)
    assert (of["inside_band"], of["below_band"], of["above_band"]) == (4, 4, 0)
    assert list(join_placed(placed)["sweep"].unique()) == ["noise"]


def test_the_fewest_poses_say_where_the_published_error_falls():
    """At 18 poses four of six seeds lie below; cases without a published point have no entry."""
    table = table_of([18.0, 30.0], lambda value, seed: 1.0 + seed)
    curve = pd.DataFrame([{"value": 18.0, **dict.fromkeys(QUANTITIES, 4.5)}])
    placed = {"poses": place_published_curve(table, curve)}
    fewest = sweep_numbers({"poses": table}, placed, {"poses": "x"})["fewest_poses"]
    assert set(fewest) == {"18"}
    of = fewest["18"]["walls"]["upright"]["proposed"]
    assert (fewest["18"]["published_mm"], of["seeds"]) == (4.5, SEEDS)
    assert of["percentile"] == pytest.approx(100 * 4 / 6)
    assert of["inside_range"]
