"""Where no noise is stated, a sentence compares the residual with the usual noise of such instruments; a known noise is compared instead."""

import re
from dataclasses import replace

import pytest

from scalar.cli.calibration_words import describe_calibration
from scalar.estimation.calibrate import calibrate
from scalar.report import render_calibration
from tests.random_scene import make_scene


@pytest.fixture(scope="module")
def poor():
    """Return a tracker's dataset that scatters by 0.5 mm and states no noise, and its calibration."""
    dataset = make_scene(kind="tracker", seed=2, poses_per_plane=12, noise=5e-4, stated_noise=None).dataset
    return dataset, calibrate(dataset)


def test_a_residual_that_no_tracker_scatters_by_is_called_too_large(poor):
    """One sentence on the terminal states the size, the usual scatter of trackers, what the rest means and what to do.

    The page does not advise use.
    """
    dataset, calibration = poor
    said = describe_calibration(calibration)
    line = next(line for line in said.splitlines() if "more than noise" in line)
    stated = float(re.search(r"residual of (\S+) mm", line)[1])
    assert stated == pytest.approx(calibration.residual_rms * 1e3, rel=1e-2)
    assert "a laser tracker scatters" in line and "the model lacks" in line and "scalar diagnose" in line
    lead = re.findall(r'<p class="lead">(.*?)</p>', render_calibration(calibration, dataset))[1]
    assert "scalar diagnose" in lead and "scalar correct" not in lead


def test_no_noise_is_invented(poor):
    """Where nobody stated a noise, only that sentence is new, and no test of the residual is claimed."""
    _, calibration = poor
    assert calibration.sensor["noise"] is None and calibration.summary["misfit_p_value"] is None


@pytest.mark.parametrize(("stated", "words"), [(None, "state sensor.noise"), (3e-5, "the noise explains")])
def test_a_small_residual_is_not_called_too_large(stated, words):
    """For a residual that a tracker may have, the sentence says how to have it tested, or, with a stated noise, gives the test."""
    scene = make_scene(kind="tracker", seed=2, poses_per_plane=12, noise=3e-5, stated_noise=stated)
    said = describe_calibration(calibrate(scene.dataset))
    assert words in said and "more than noise" not in said
    assert ("a laser tracker" in said) == (stated is None)


@pytest.mark.parametrize(
    ("ratio", "p_value", "told"),
    [
        (1.2, 5e-4, "lacks something"),
        (1.2, 2e-3, "may lack something"),
        (1.1, 5e-4, "may lack something"),
        (1.1, 5e-3, "may lack something"),
        (1.1, 2e-2, "the noise explains the residual"),
        (1.0, 0.5, "the noise explains the residual"),
    ],
)
def test_a_residual_beyond_the_noise_is_said_as_surely_as_it_is(ratio, p_value, told):
    """Terminal and page say that the model lacks something, that it may, or that the noise explains the residual; two name `diagnose`."""
    dataset = make_scene(kind="tracker", seed=2, poses_per_plane=12, noise=3e-5).dataset
    made = calibrate(dataset)
    made = replace(made, summary={**made.summary, "misfit": ratio, "misfit_p_value": p_value})
    said = describe_calibration(made)
    lead = re.findall(r'<p class="lead">(.*?)</p>', render_calibration(made, dataset))[1]
    explained = told.startswith("the noise")
    assert told in said and ("scalar diagnose" in said) != explained
    assert (told in lead) != explained and ("scalar diagnose" in lead) != explained
