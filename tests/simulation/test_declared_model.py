"""The nominal arm and the guesses of planes in a dataset have the declared errors, and do not change the data."""

import numpy as np
import pandas as pd
import pytest

from scalar.simulation import simulate
from scalar.simulation.declared import draw_errors, guess_plane
from scalar.units import DEG
from tests.simulation.conftest import scene_config
from tests.simulation.noise_checks import assert_standard_normal

MODEL = {"length_std_m": 0.002, "angle_std_deg": 1.0, "beta_std_deg": 0.5, "sensor": True, "exact": []}


def test_the_declared_model_does_not_touch_the_data(paper):
    """What the dataset declares as nominal changes neither poses nor scans."""
    config = scene_config("paper")
    other = simulate(config | {"initial_model": config["initial_model"] | {"length_std_m": 0.01}})
    pd.testing.assert_frame_equal(simulate(config).scans, other.scans)


def test_exact_parameters_are_the_truth_and_the_others_are_not(paper):
    """Of the declared model the named parameters equal the truth, and every other differs."""
    exact = set(paper.config["initial_model"]["exact"])
    assert len(exact) == 7
    for i, joint in enumerate(paper.dataset["robot"]["joints"]):
        for name in ("a", "d", "alpha", "theta"):
            same = joint[name] == paper.truth["parameters"][name][i]
            assert same == (f"{name}_{i + 1}" in exact)
    assert paper.dataset["sensor"]["nominal_pose"]["translation"] != paper.truth["parameters"]["t"]


def test_model_errors_have_the_declared_spread():
    """Errors of lengths and angles are independent Gaussian with their declared standard deviations."""
    draws = [draw_errors(MODEL, 6, np.random.default_rng(seed)) for seed in range(100)]
    for names, std in (
        (("a", "d", "t"), 0.002),
        (("alpha", "theta", "r"), 1.0 * DEG),
        (("beta",), 0.5 * DEG),
    ):
        assert_standard_normal([np.concatenate([draw[name] for name in names]) / std for draw in draws])


def test_an_exact_parameter_leaves_the_others_their_errors():
    """Declaring one parameter exact changes no other error."""
    free = draw_errors(MODEL, 6, np.random.default_rng(0))
    held = draw_errors(MODEL | {"exact": ["a_2", "sensor_rz"]}, 6, np.random.default_rng(0))
    assert held["a"][1] == 0.0 and held["r"][2] == 0.0
    free["a"][1] = free["r"][2] = 0.0
    for name, values in free.items():
        np.testing.assert_array_equal(held[name], values)


@pytest.mark.parametrize("seed", range(5))
def test_plane_guesses_are_off_by_what_was_declared(paper, seed):
    """A guess is tilted by exactly the declared angle and off by exactly the declared distance."""
    block = {"offset_m": 0.1, "offset_std_m": 0.0, "tilt_deg": 30.0, "tilt_std_deg": 0.0}
    for target_plane in paper.workcell.target_planes:
        guess = guess_plane(target_plane, block, np.random.default_rng(seed))
        normal = np.array(guess["normal"])
        assert np.linalg.norm(normal) == pytest.approx(1.0, abs=1e-14)
        assert np.arccos(normal @ target_plane.normal) / DEG == pytest.approx(30.0, abs=1e-9)
        assert abs(guess["distance"] - target_plane.distance) == pytest.approx(0.1, abs=1e-14)
