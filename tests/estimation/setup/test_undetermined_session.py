"""A session with too few poses to tell where the tracker stood is named, with what to do."""

from dataclasses import replace

import numpy as np
import pytest

from scalar import calibrate
from scalar.errors import Undetermined
from scalar.estimation.setup.sessions.undetermined_session import undetermined_session
from tests.random_scene import make_scene


def in_sessions(few):
    """Return seventy-five tracked poses, the last ``few`` of them in a session of their own."""
    dataset = make_scene("vs060", "tracker", poses_per_plane=25, noise=1e-4, seed=7).dataset
    names = np.where(np.arange(75) < 75 - few, "morning", "evening").astype(object)
    return replace(dataset, poses=dataset.poses.assign(session=names))


def test_two_poses_of_a_session_do_not_say_how_the_tracker_was_turned():
    """About the line through the two, the tracker may be turned as it likes; with ten poses its place is determined."""
    with pytest.raises(Undetermined, match="in session 'evening' 2 poses do not determine where the tracker"):
        calibrate(in_sessions(2), explain=False)
    assert calibrate(in_sessions(10)).residual_rms < 3e-4


def test_other_parameters_are_of_no_session():
    dataset = in_sessions(2)
    assert not undetermined_session(dataset, ["tracker@1_x", "tracker@2_x"])
    assert not undetermined_session(dataset, ["tracker@1_x", "a_2"])
    assert not undetermined_session(replace(dataset, poses=dataset.poses.drop(columns="session")), ["a_2"])
