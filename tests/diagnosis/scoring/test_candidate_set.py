"""The candidates for a dataset: every kind of effect where it can act, and no kind where it cannot."""

from dataclasses import replace

import numpy as np
import pytest

from scalar.diagnosis.scoring.candidate_set import candidates, changes, elements, flexible
from scalar.effects import registry
from tests.effects.everything import optional_columns
from tests.effects.injected import make_cell
from tests.random_scene import make_scene
from tests.turning import turning


@pytest.fixture(scope="module")
def dataset():
    """Return the dataset of a small workcell."""
    return make_cell(seed=5, poses_per_plane=8, points_per_scan=6, columns=optional_columns).dataset


def test_every_named_kind_is_a_candidate_for_scans(dataset):
    """Every named kind is among the candidates or the changes for scans, except ripples, which are found as a part of all orders, drifts of a whole
    target, warm-ups after stops, of which this record has none, and hysteresis, for which moves have to be direct.
    """
    tried = {e.name for e in candidates(dataset)} | {e.name for e, _ in changes(dataset)}
    assert tried == {kind.name for kind in registry.BUILT_IN if not kind.flexible} - {
        "joint_ripple",
        "target_drift",
        "restarted_warm_up",
        "joint_hysteresis",
    }


@pytest.mark.parametrize("kind", ["probe", "tracker"])
def test_a_sensor_without_ranges_has_no_errors_of_ranges(kind):
    """Probe and tracker have no candidates for errors of a laser's range, and a tracker has none for target planes."""
    data = make_scene(seed=3, poses_per_plane=10, kind=kind).dataset
    tried = {e.name for e in candidates(data)} | {e.name for e, _ in changes(data)}
    assert not {name for name in tried if name.startswith("range_")}
    assert kind == "probe" or not {name for name in tried if name.startswith("plane_")}


def test_a_joint_that_stands_still_has_no_candidates(dataset):
    """No candidate is an error of a joint that never moves."""
    still = replace(dataset, poses=dataset.poses.assign(q5=0.3))
    assert not [e for e in candidates(still) if e.erring_joint == 5]
    assert [e for e in candidates(dataset) if e.erring_joint == 5]


def test_elements_are_the_columns_of_the_whole(dataset):
    """The columns of the elements of an effect, one after the other, are those of the effect, at any poses."""
    from scalar.data.poses import Poses

    poses = Poses.from_frame(dataset.poses, turning(6), order_is_row=True)
    for effect in candidates(dataset):
        if effect.n_terms > 1 and hasattr(effect, "joint_basis"):
            whole = effect.joint_basis(dataset.robot, poses)
            parts = np.concatenate([e.joint_basis(dataset.robot, poses) for e in elements(effect)], axis=2)
            np.testing.assert_array_equal(parts, whole)


def test_flexible_terms_say_what_they_depend_on(dataset):
    """Every flexible term is marked as flexible and names the columns that it varies with; among these is a covariate of unknown meaning."""
    terms = flexible(dataset)
    assert all(term.flexible and term.depends_on for term in terms)
    assert any(term.depends_on == ["humidity"] for term in terms)


def test_a_drift_of_the_target_is_a_candidate_for_a_tracker():
    """A tracker may drift relative to the base; target planes are not one target, and have no such candidate."""
    for kind, tried in (("tracker", True), ("probe", False)):
        data = make_scene(seed=3, poses_per_plane=45, kind=kind).dataset
        assert ("target_drift" in {e.name for e in candidates(data)}) == tried
