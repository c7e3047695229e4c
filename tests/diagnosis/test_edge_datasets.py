"""Unusual datasets: the diagnosis states what can still be determined, or exits with status 3 and a reason; it never ends with a traceback."""

from dataclasses import replace

import numpy as np
import pytest

from scalar.data.declared import PlaneGuess
from scalar.diagnosis import diagnose
from scalar.errors import ScalarError, Undetermined
from tests.diagnosis.cases import scale
from tests.diagnosis.gross_errors import spoiled
from tests.effects.injected import Flaws, make_cell, on_joint
from tests.random_scene import make_scene


def said(dataset):
    """Return the verdict, or the exit status and the message if there is no verdict; any other exception fails the test."""
    try:
        diagnosis = diagnose(dataset)
    except ScalarError as error:
        assert len(str(error)) > 30, "a refusal says why"
        return error.exit_status, str(error)
    return diagnosis.verdict, diagnosis.to_mapping()


@pytest.mark.parametrize("kind", ["probe", "tracker"])
def test_contacts_and_tracked_points_can_be_diagnosed(kind):
    """Contacts of a probe and points of a tracker can be diagnosed: no effect is named without one, and a joint's scale error is found."""
    verdict, _ = said(make_scene(kind=kind, seed=1, poses_per_plane=80).dataset)
    assert verdict == "no_effect"


@pytest.mark.slow
def test_a_tracked_joint_error_is_named():
    """With a tracker, an error of a joint's angle is named with its joint."""
    right = 0
    for seed in range(3):
        scene = make_scene(kind="tracker", seed=seed, poses_per_plane=60)
        q = scene.dataset.q
        # The arm stood at q: the encoder read e with e + 1e-3 e_3 = q.
        poses = scene.dataset.poses.assign(q3=q[:, 2] / (1 + 1e-3))
        verdict, mapping = said(replace(scene.dataset, poses=poses))
        first = mapping["effects"][0] if verdict == "effect" else {}
        right += first.get("name") == "joint_scale" and first["target"] == {"joint": 3}
    assert right == 3


@pytest.mark.slow
@pytest.mark.parametrize("poses_per_plane", [1, 2, 3, 5, 7, 8, 10, 13])
def test_few_poses_are_refused_or_give_no_effect(poses_per_plane):
    """With too few poses, or hardly enough to hold any out, the exit status is 3 with a reason, or no effect is named."""
    for seed in range(2):
        verdict, text = said(make_cell(seed=seed, poses_per_plane=poses_per_plane).dataset)
        assert verdict in (3, "no_effect"), text
        if poses_per_plane <= 5:
            assert verdict == 3


def test_scans_of_two_points_can_be_diagnosed():
    """Scans of two points have no scatter and no curvature; they are diagnosed by the remaining rows."""
    verdict, mapping = said(make_cell(seed=3, points_per_scan=2, poses_per_plane=80).dataset)
    assert verdict == "no_effect", mapping


def test_unequal_numbers_of_poses_and_points_give_no_effect():
    """With few poses on one plane and many on others, and scans of 5 to 90 points, no effect is named that is not there."""
    dataset = make_cell(seed=4, poses_per_plane=80, points_per_scan=(5, 90)).dataset
    few = np.flatnonzero((dataset.plane_index != 1) | (np.arange(dataset.n_poses) % 8 == 0))
    verdict, mapping = said(dataset.subset(few))
    assert verdict == "no_effect", mapping


@pytest.mark.slow
def test_an_effect_so_large_that_the_first_fit_fails():
    """If a joint errs by a tenth of a radian, something is found or the data are refused; they are never said to be without effects."""
    error = on_joint(3, lambda at: 0.1 * np.sin(at.q[:, 2] * at.q[:, 1]))
    verdict, _ = said(make_cell(Flaws(joints=error), seed=5).dataset)
    assert verdict in (2, 3, "effect", "unattributed")


@pytest.mark.slow
def test_a_plane_measured_along_one_line_is_refused_or_fixed():
    """A plane that was measured along one line only does not determine its normal: the exit status is 3 with its name, or the undetermined part is
    fixed.
    """
    dataset = make_cell(seed=6).dataset
    first = int(np.flatnonzero(dataset.plane_index == 2)[0])
    keep = np.flatnonzero((dataset.plane_index != 2) | (np.arange(dataset.n_poses) == first))
    verdict, text = said(dataset.subset(keep))
    assert verdict in (3, "no_effect")
    if verdict == 3:
        assert "wall_y" in text


@pytest.mark.slow
@pytest.mark.parametrize("how", ["in turn", "at random"])
def test_labels_that_are_all_wrong_are_refused(how):
    """If all labels are wrong, the exit status is 3, and the message asks for the labels to be checked."""
    data = make_cell(seed=7).dataset
    shift = np.random.default_rng(1).integers(1, 3, data.n_poses) if how == "at random" else 1
    names = np.array([plane.name for plane in data.planes], dtype=object)
    poses = data.poses.assign(plane=names[(data.plane_index + shift) % 3])
    status, text = said(replace(data, poses=poses))
    assert status == 3 and "label" in text


@pytest.mark.slow
def test_half_of_all_poses_wrong_give_no_effect():
    """If half of the poses are wrong, the exit status is 3, or the right poses are found; an effect is never named."""
    dataset, _ = spoiled(make_cell(seed=8).dataset, np.random.default_rng(2), poses=0.5)
    verdict, text = said(dataset)
    assert verdict in (3, "no_effect"), text


def test_no_error_of_a_joint_that_never_moves_is_named():
    """An error of a joint that never moves cannot be observed, and none is named."""
    verdict, mapping = said(make_cell(seed=9, still_joint=4).dataset)
    assert verdict in (3, "no_effect"), mapping


def test_constant_columns_and_huge_covariates_change_nothing():
    """Optional columns that are constant or nearly so, and a covariate of huge numbers, change nothing."""
    dataset = make_cell(seed=10).dataset
    n = dataset.n_poses
    extra = {
        "temperature": np.full(n, 21.0),
        "time": np.zeros(n),
        "approach1": np.ones(n),
        "serial": np.full(n, 1e12) + np.arange(n) % 7,
    }
    verdict, mapping = said(replace(dataset, poses=dataset.poses.assign(**extra)))
    assert verdict == "no_effect", mapping


def test_sessions_share_the_arm_and_not_the_planes():
    """If planes and sensor stand elsewhere in each session, no effect is named, and a joint's scale error is common to both sessions."""
    cell, name, target = scale(11, poses_per_plane=80)
    sessions = np.repeat([1, 2], cell.dataset.n_poses // 2)
    verdict, mapping = said(replace(cell.dataset, poses=cell.dataset.poses.assign(session=sessions)))
    assert verdict == "effect"
    assert (mapping["effects"][0]["name"], mapping["effects"][0]["target"]) == (name, target)


def test_a_sensor_pose_that_is_not_stated_is_estimated():
    """If the pose of a line laser on the flange is not stated, it is estimated first, and the diagnosis is as usual."""
    cell, name, target = scale(12, nominal_pose=False)
    verdict, mapping = said(cell.dataset)
    assert verdict == "effect"
    assert (mapping["effects"][0]["name"], mapping["effects"][0]["target"]) == (name, target)


@pytest.mark.slow
def test_reference_planes_show_the_gain():
    """Planes known to 10 micrometres determine the scale of lengths: a gain of the range is then no longer unobservable."""
    cell = make_cell(Flaws(measured=lambda r: r / (1 + 2e-3)), seed=13, poses_per_plane=60)
    verdict, mapping = said(cell.dataset)
    assert verdict == "no_effect"
    assert any(s["name"] == "range_scale" for s in mapping["unobservable"])
    truth = cell.scene.truth
    known = tuple(
        PlaneGuess(p.name, n, float(d), 1e-5, 1e-4)
        for p, n, d in zip(cell.dataset.planes, truth.normals, truth.distances, strict=True)
    )
    verdict, mapping = said(replace(cell.dataset, planes=known))
    assert verdict in ("no_effect", "effect")
    assert not any(s["name"] == "range_scale" for s in mapping["unobservable"])


def test_measurements_without_noise_give_no_effect():
    """Measurements without any noise, and without a stated noise, give no effect and no error message."""
    verdict, mapping = said(make_cell(seed=14, noise=0.0, stated_noise=None).dataset)
    assert verdict == "no_effect", mapping


def test_refusals_are_undetermined():
    """A diagnosis that is refused because the data do not suffice has exit status 3."""
    with pytest.raises(Undetermined) as caught:
        diagnose(make_cell(seed=15, poses_per_plane=2).dataset)
    assert caught.value.exit_status == 3 and caught.value.reasons


@pytest.mark.parametrize(("kind", "coordinates"), [("tracker", 3), ("probe", 1)])
def test_a_noise_that_is_not_stated_is_estimated_from_the_residual(kind, coordinates):
    """For a tracker without a stated noise, 0.02 mm for each coordinate is found to a tenth, and no scatter of scans is stated, because there are
    none.
    """
    scene = make_scene(kind=kind, seed=31, poses_per_plane=40, noise=2e-5, stated_noise=None)
    verdict, mapping = said(scene.dataset)
    assert verdict == "no_effect"
    assert mapping["noise"]["within_scan_mm"] == pytest.approx(0.02, rel=0.1)
    assert mapping["noise"]["between_scans_mm"] == 0.0
    assert mapping["residual"]["floor_mm"] == pytest.approx(0.02 * np.sqrt(coordinates), rel=0.1)
