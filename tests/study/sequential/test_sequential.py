"""At once or in sequence: alternating ends where all at once ends, at the rate that the Jacobian predicts."""

from itertools import islice

import numpy as np
import pandas as pd
import pytest
from study.common.grid import with_overrides
from study.common.in_memory import dataset_in_memory
from study.common.statistics import QUANTITIES
from study.sequential.compare import (
    AT_ONCE,
    CONVERGED_WITHIN,
    ORDERS,
    SEQUENTIAL_COLUMNS,
    Blocks,
    compare_sequential,
    compare_ways,
    contraction,
    passes,
    remaining,
    starts,
)
from study.sequential.summary import sequential_numbers, staged, summarise_sequential

from scalar.estimation.joint_fit import fit_from
from scalar.estimation.prepare import prepare
from scalar.estimation.residuals import Residuals
from scalar.simulation.config import load_config
from scalar.simulation.plan import plan_poses
from scalar.simulation.scene import simulate

SCENE = "configs/scenes/paper.yaml"
SMALL = {"poses_per_plane": 20, "sensor.points_per_scan": 30, "truth_poses": 100}


@pytest.fixture(scope="module")
def repository(request):
    """Return the checkout."""
    return request.config.rootpath


@pytest.fixture(scope="module")
def base(repository):
    """Return (config, base folder, postures) of a small scene of the paper's workcell."""
    config = with_overrides(load_config(repository / SCENE), SMALL)
    folder = (repository / SCENE).parent
    return config, folder, plan_poses(config, base_dir=folder)


def scene_of(base, **overrides):
    """Return the small scene with keys replaced."""
    config, folder, plan = base
    return simulate(with_overrides(config, overrides), base_dir=folder, plan=plan)


@pytest.fixture(scope="module")
def fitted(base):
    """Return ``(dataset, prepared, blocks, optimum, residuals)`` of the small scene."""
    dataset = dataset_in_memory(scene_of(base))
    prepared = prepare(dataset)
    optimum, residuals = fit_from(dataset, prepared.initial.model, prepared.free)
    return dataset, prepared, Blocks.of(prepared), optimum, residuals


def test_blocks_overlap_in_the_planes_alone(fitted):
    """The two blocks together free exactly the coordinates of the fit at once, and share those of the planes."""
    _, prepared, blocks, _, _ = fitted
    assert np.array_equal(blocks.scanner | blocks.robot, prepared.free)
    assert np.array_equal(blocks.scanner & blocks.robot, blocks.planes)
    assert blocks.planes.sum() == 9
    assert (blocks.scanner & ~blocks.planes).sum() == 6


def test_a_step_moves_its_own_block_only(fitted):
    """The scanner's step leaves the arm nominal, the arm's step leaves the scanner where it is declared."""
    dataset, prepared, blocks, _, _ = fitted
    first = starts(dataset, prepared)["declared"]
    _, after, _ = next(passes(Residuals.of(dataset, first), first, [blocks.scanner]))
    assert np.array_equal(after.robot.geometry, dataset.robot.geometry)
    assert not np.allclose(after.T_flange_sensor, dataset.sensor.T_flange_sensor)
    _, after, _ = next(passes(Residuals.of(dataset, first), first, [blocks.robot]))
    assert np.allclose(after.T_flange_sensor, dataset.sensor.T_flange_sensor, rtol=0, atol=1e-15)
    assert not np.allclose(after.robot.geometry, dataset.robot.geometry)


@pytest.mark.parametrize("way", ORDERS)
def test_alternating_ends_at_the_joint_optimum(fitted, way):
    """In every order the sum of squares falls to that of the fit at once, and not below it."""
    dataset, prepared, blocks, optimum, residuals = fitted
    start, order = ORDERS[way]
    first = starts(dataset, prepared)[start]
    steps = [getattr(blocks, name) for name in order]
    gaps = []
    for _, model, reached in islice(passes(Residuals.of(dataset, first), first, steps), 60):
        gaps.append(remaining(reached, model, blocks.everything))
        if gaps[-1] < 1e-3:
            break
    assert gaps[-1] < 1e-3
    cost = float(np.sum(residuals.residual(model) ** 2))
    assert optimum.chi_squared <= cost * (1 + 1e-9)
    assert cost - optimum.chi_squared < 0.01  # of a squared standard error


def test_the_jacobian_predicts_the_rate_of_passes(fitted):
    """Near the optimum each pass shrinks what is left by cos^2 of the smallest angle between the blocks."""
    dataset, prepared, blocks, optimum, residuals = fitted
    rate = contraction(residuals, optimum.model, blocks)
    first = starts(dataset, prepared)["declared"]
    walk = islice(passes(Residuals.of(dataset, first), first, [blocks.scanner, blocks.robot]), 40)
    gaps = np.array([remaining(reached, model, blocks.everything) for _, model, reached in walk])
    ratios = gaps[1:] / gaps[:-1]
    late = ratios[(gaps[1:] > 1e-5) & (gaps[1:] < 1e-3)]  # faster directions have died away, rounding is far
    assert len(late) >= 5
    assert late[-3:] == pytest.approx(rate, rel=0.02)


def test_with_a_true_arm_the_scanner_alone_is_enough(base):
    """Without errors of the arm and without noise, one pass finds the truth: what a sequence costs is the arm's error."""
    zero = {
        "initial_model.length_std_m": 0.0,
        "initial_model.angle_std_deg": 0.0,
        "noise.range_noise_std_m": 0.0,
    }
    scene = scene_of(base, **zero)
    found = pd.DataFrame(compare_ways(dataset_in_memory(scene), scene.truth_poses, alternate=False))
    for way in ("scanner_first", AT_ONCE):
        row = found[(found["way"] == way) & (found["alignment"] == "raw")].iloc[0]
        assert row["position_mean_mm"] < 1e-6, way


def test_a_table_has_every_case_seed_way_and_pass(repository):
    """A way has one pass if one is asked for, else passes up to one that has converged, and the last is marked."""
    cases = {"on": SMALL, "once": SMALL | {"poses_per_plane": 14}}
    table = compare_sequential(repository / SCENE, cases, [1], ["on"])
    assert list(table.columns) == list(SEQUENTIAL_COLUMNS)
    raw = table[table["alignment"] == "raw"]
    for case, poses in (("on", 60), ("once", 42)):
        own = raw[raw["case"] == case]
        assert set(own["poses"]) == {poses}
        assert set(own["way"]) == {"initial", AT_ONCE, *ORDERS}
        for _, walk in own[own["way"].isin(ORDERS)].groupby("way"):
            assert list(walk["passes"]) == list(range(1, len(walk) + 1))
            assert list(walk["last"]) == [False] * (len(walk) - 1) + [True]
            assert (len(walk) == 1) == (case == "once")
            if case == "on":
                assert walk["remaining_std"].iloc[-1] < CONVERGED_WITHIN <= walk["remaining_std"].iloc[-2]


def made_up():
    """Return a table of two seeds: all at once 1 and 2, one pass 10 and 10, its end 1.5 and 1; a third seed failed."""
    common = {"case": "c", "poses": 6, "noise_mm": 0.1, "length_error_mm": 2.0, "angle_error_deg": 1.0}
    common |= {"alignment": "raw", "residual_rms_mm": 0.1, "remaining_std": 0.0, "rate": 0.5}
    rows = []
    for seed, at_once, last in ((1, 1.0, 1.5), (2, 2.0, 1.0)):
        for way, done, is_last, status, size in (
            ("initial", 0, True, "initial", 50.0),
            (AT_ONCE, 0, True, "converged", at_once),
            ("scanner_first", 1, False, "", 10.0),
            ("scanner_first", 2, False, "", 5.0),
            ("scanner_first", 3, True, "stopped" if seed == 2 else "converged", last),
        ):
            rows.append(
                common | {"seed": seed, "way": way, "passes": done, "last": is_last, "status": status}
            )
            rows[-1] |= dict.fromkeys(QUANTITIES, size)
    for way in (AT_ONCE, "scanner_first"):
        rows.append(common | {"seed": 3, "way": way, "passes": 0, "last": True, "status": "Undetermined"})
    return pd.DataFrame(rows).reindex(columns=list(SEQUENTIAL_COLUMNS))


def test_the_summary_compares_within_each_seed():
    """Ratios are of the same seed, intermediate passes are left out, and failures and ends that did not converge are counted."""
    errors = made_up()
    assert len(staged(errors)) == 2 * 4 + 3  # the failed seed counts in every stage
    summary = summarise_sequential(errors)
    of = summary[summary["quantity"] == "position_mean_mm"].set_index(["way", "stage"])
    one, end = of.loc[("scanner_first", "one_pass")], of.loc[("scanner_first", "alternating")]
    assert (one["median"], one["times_at_once_median"], one["worse_than_at_once"]) == (10.0, 7.5, 1.0)
    assert (end["times_at_once_median"], end["worse_than_at_once"], end["not_converged"]) == (1.0, 0.5, 1)
    assert end["passes_max"] == 3
    assert (one["failed"], end["failed"], of.loc[(AT_ONCE, "at_once"), "failed"]) == (1, 1, 1)
    assert of.loc[("initial", "before"), "times_at_once_median"] == (50.0 + 25.0) / 2
    numbers = sequential_numbers(errors, summary)["cases"]["c"]
    assert numbers["ways"]["scanner_first"]["one_pass"]["times_at_once"]["position_mean"]["median"] == 7.5
    assert numbers["pass_leaves"]["median"] == 0.5
