"""The linear estimate of the scanner's pose, and the declared pose, are compared with the truth."""

import numpy as np
import pytest
from study.headline.linear_estimate import DECLARED, LINEAR, estimate_numbers, linear_estimates
from study.headline.simulate import simulate_seeds

PERFECT = {
    "poses_per_plane": 14,
    "sensor.points_per_scan": 20,
    "truth_poses": 10,
    "noise.range_noise_std_m": 0.0,
    "plane_guess.offset_m": 0.0,
    "plane_guess.tilt_deg": 0.0,
    "initial_model.length_std_m": 0.0,
    "initial_model.angle_std_deg": 0.0,
}


@pytest.fixture(scope="module")
def scene(request):
    """Return the scene of the paper."""
    return request.config.rootpath / "configs/scenes/paper.yaml"


def test_with_a_perfect_model_the_estimate_is_the_truth(scene, tmp_path):
    """With the true arm, the true plane and no noise, the estimate is the true pose."""
    simulate_seeds(scene, PERFECT, [1], tmp_path)
    table = linear_estimates([tmp_path]).set_index("start")
    assert table.loc[LINEAR, "position_mm"] < 1e-6
    assert table.loc[LINEAR, "orientation_deg"] < 1e-5
    assert table.loc[DECLARED, "position_mm"] < 1e-6


def test_errors_of_the_arm_and_the_plane_go_into_the_estimate(scene, tmp_path):
    """There is a row for each seed and start; the numbers are statistics of these rows."""
    simulate_seeds(scene, {key: PERFECT[key] for key in list(PERFECT)[:3]}, [1, 2], tmp_path)
    table = linear_estimates([tmp_path])
    assert sorted(zip(table["start"], table["seed"], strict=True)) == [
        (DECLARED, 1), (DECLARED, 2), (LINEAR, 1), (LINEAR, 2)
    ]  # fmt: skip
    linear = table[table["start"] == LINEAR]["position_mm"]
    assert linear.min() > 1.0
    numbers = estimate_numbers(table)
    assert numbers[LINEAR]["position_mm"]["mean"] == pytest.approx(np.mean(linear))
