"""Poses that are a centimetre off with all effects in the model: a few are set aside, and more are refused."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from scalar.diagnosis import cleaning, explained
from scalar.diagnosis.cleaning import refuse_gross_errors_left, without_far_poses
from scalar.diagnosis.settings import DEFAULTS
from scalar.errors import Undetermined
from scalar.estimation.gross_errors import Cleaned
from scalar.units import MM
from tests.random_scene import make_scene

USUAL = 3 * MM  # such as a camera leaves


@pytest.fixture(scope="module")
def tracked():
    """Return a hundred tracked poses."""
    dataset = make_scene("vs060", "tracker", seed=3, poses_per_plane=34, noise=1e-4).dataset
    return dataset.subset(np.arange(100))


@pytest.fixture(autouse=True)
def set_up_as_described(monkeypatch):
    """Let no other description of the set-up explain the data."""
    monkeypatch.setattr(cleaning, "refuse_wrong_setup", lambda _: None)


def leaving(*far: float) -> Any:
    """Return a stand-in for a fit that leaves ``far`` [mm] at the first of a hundred poses, and the usual distance at the others."""
    distances = np.full(100, USUAL)
    distances[: len(far)] = np.array(far) * MM
    residuals = SimpleNamespace(pose_distances=lambda _: distances)
    return SimpleNamespace(settings=DEFAULTS, model=None, residuals=residuals)


def test_up_to_five_poses_of_a_hundred_are_set_aside(tracked):
    """They are listed after what cleaning has set aside, and the others remain."""
    ids = [int(pose) for pose in tracked.pose_ids]
    for far in ((12.0,), (31.0, 12.0, 12.0, 12.0, 12.0)):
        found = without_far_poses(tracked, Cleaned(tracked, (999,), (), 0), leaving(*far))
        assert found.outlier_poses == (999, *ids[: len(far)])
        assert found.dataset.pose_ids.tolist() == ids[len(far) :]


@pytest.mark.parametrize("far", [(), (9.0,), (12.0,) * 6])
def test_nearer_poses_and_more_than_a_few_are_not(tracked, far):
    cleaned = Cleaned(tracked, (), (), 0)
    assert without_far_poses(tracked, cleaned, leaving(*far)) is cleaned


def test_a_diagnosis_that_refuses_sends_nobody_to_a_diagnosis(tracked):
    """Of a hundred poses, six that are far off are refused by their names."""
    state = leaving(*np.linspace(12.0, 14.0, 6))
    state.dataset = tracked
    with pytest.raises(Undetermined, match="remove them if they do not") as refused:
        refuse_gross_errors_left(tracked, state)
    assert "scalar diagnose" not in str(refused.value)


@pytest.mark.parametrize(("far", "runs"), [(0, 1), (1, 2), (2, 3), (9, 3)])
def test_what_remains_is_explained_anew(far, runs, monkeypatch):
    """Each time that poses are set aside the rest is explained without them, twice at most; what is returned is of the poses that remain."""
    given: list[Any] = []

    def explained_from(dataset, cleaned, settings, progress):
        given.append(cleaned)
        return SimpleNamespace(cleaned=cleaned, after=None)

    monkeypatch.setattr(explained, "cleaned_or_refused", lambda *_: 0)
    monkeypatch.setattr(explained, "_explained_from", explained_from)
    monkeypatch.setattr(explained, "without_far_poses", lambda _, cleaned, state: min(cleaned + 1, far))
    monkeypatch.setattr(explained, "refuse_gross_errors_left", lambda *_: None)
    found: Any = explained.explained(None, DEFAULTS, lambda stage: None)  # type: ignore[arg-type]
    assert given == list(range(runs)) and found.cleaned == runs - 1
