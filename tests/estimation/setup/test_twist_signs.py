"""A twist that was typed with the wrong sign is named, with what the table of joints has to say."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from scalar.data.dataset import Dataset
from scalar.estimation.calibrate import calibrate
from scalar.estimation.setup.alternatives import ALPHA, read_as_standard
from scalar.estimation.setup.plainer_reading import plainer_reading
from scalar.estimation.setup.suspicion import WrongSetup
from scalar.estimation.setup.tables.mistyped_numbers import twist_signs, with_all_twists_back
from scalar.geometry.standard_dh import stated_mapping
from scalar.units import MM
from tests.random_scene import make_scene


def with_wrong_sign(dataset: Dataset, joint: int) -> Dataset:
    """Return the dataset with alpha of a joint (from 1) negated in its table of joints."""
    geometry = dataset.robot.geometry.copy()
    geometry[ALPHA, joint - 1] *= -1
    return replace(dataset, robot=dataset.robot.with_geometry(geometry))


@pytest.mark.parametrize(
    ("kind", "joint"),
    [
        ("tracker", 5),
        *(pytest.param("tracker", joint, marks=pytest.mark.slow) for joint in (2, 4, 6)),
        *(pytest.param("line-laser", joint, marks=pytest.mark.slow) for joint in (2, 4, 5, 6)),
    ],
)
def test_a_twist_with_the_wrong_sign_is_named(kind, joint):
    """It is named, alone or among corrections that explain the data as well, with the residual that a table without the error has."""
    scene = make_scene("vs060", kind, poses_per_plane=25, points_per_scan=12, noise=1e-4, seed=7)
    with pytest.raises(WrongSetup) as refused:
        calibrate(with_wrong_sign(scene.dataset, joint))
    named = {suspicion.where: suspicion for suspicion in refused.value.suspicions}
    suspicion = named[f"alpha_{joint}"]
    assert suspicion.what == "twist_sign" and "the residual falls from" in suspicion.sentence
    assert suspicion.rms_after is not None and suspicion.rms_after < 0.3 * MM
    assert suspicion.robot is not None  # so that the command offers a corrected dataset.yaml
    np.testing.assert_array_equal(suspicion.robot.geometry, scene.dataset.robot.geometry)
    if (kind, joint) != (
        "tracker",
        2,
    ):  # its tracker may hang upside down, where joint 1 would count the other way
        assert len(named) == 1


def test_twists_are_named_by_the_row_of_the_user_s_table():
    """In standard DH the twist stands in the row before; the corrected table is in standard DH and differs in that number alone."""
    dataset = make_scene("vs060", "tracker", poses_per_plane=8, noise=1e-4, seed=7).dataset
    dataset = replace(dataset, robot=read_as_standard(dataset.robot))
    before = stated_mapping(dataset.robot)["joints"]
    *found, of_all = twist_signs(dataset)
    assert of_all.where == "alpha"
    assert len(found) == sum(abs(np.sin(row["alpha"])) > 0.5 for row in before[:-1])
    for alternative in found:
        row = int(alternative.where.removeprefix("alpha "))
        after = stated_mapping(alternative.dataset.robot)
        assert after["convention"] == "standard-dh"
        for i, (one, other) in enumerate(zip(before, after["joints"], strict=True), start=1):
            assert other["alpha"] == pytest.approx(-one["alpha"] if i == row else one["alpha"])
            assert {k: v for k, v in one.items() if k != "alpha"} == {
                k: v for k, v in other.items() if k != "alpha"
            }


def test_axes_that_are_almost_parallel_have_no_sign_to_try():
    """A fit finds a twist of a few degrees from either side."""
    dataset = make_scene("vs060", "tracker", poses_per_plane=8, noise=1e-4, seed=7).dataset
    tried = {alternative.where for alternative in twist_signs(dataset)}
    assert "alpha_3" not in tried and "alpha_2" in tried


@pytest.mark.parametrize("kind", ["tracker", "line-laser"])
def test_twists_that_all_have_the_wrong_sign_are_named(kind):
    """They are named, in a refusal or beside what a calibration suspects; before planes, the mirror image of the arm explains the data as well."""
    dataset = make_scene("vs060", kind, poses_per_plane=25, points_per_scan=12, noise=1e-4, seed=7).dataset
    wrong = replace(dataset, robot=with_all_twists_back(dataset.robot))
    try:
        told = [(entry["what"], entry["sentence"]) for entry in calibrate(wrong).summary["setup"]]
    except WrongSetup as refused:
        told = [(suspicion.what, suspicion.sentence) for suspicion in refused.suspicions]
    assert any("all twists alpha" in sentence for _, sentence in told)
    assert {what for what, _ in told} <= {"twist_sign", "joint_reading", "joint_sign"}


def test_the_guess_of_a_plane_may_be_all_that_is_far_off():
    """Where the mirror image of the arm comes out as the table has it, the twists are named by the plane that is far from its guess."""
    dataset = make_scene("panda", poses_per_plane=20, points_per_scan=12, noise=1e-4, seed=7).dataset
    wrong = replace(dataset, robot=with_all_twists_back(dataset.robot))
    far = {"what": "plane_guess", "where": "floor", "sentence": "the guess of plane floor is far off: ..."}
    (told,) = plainer_reading(wrong, calibrate(wrong).model, [far])
    assert told.where == "alpha" and told.sentence.startswith("the guess of plane floor is far off. But")
    assert "all planes" in told.sentence
    assert not plainer_reading(wrong, calibrate(wrong).model, [])
