"""What begins in the course of a campaign is named with the number of its pose, wherever the order of acquisition is named."""

import re
from dataclasses import replace

import numpy as np
import pytest

from scalar.cli.diagnosis_words import describe_diagnosis
from scalar.diagnosis import diagnose
from scalar.effects.command_line import parse_effects
from scalar.report import render_report
from scalar.report.fleet_row import row_of
from scalar.report.pose_numbers import with_pose_numbers
from tests.diagnosis.cases import slip
from tests.effects.everything import every_effect
from tests.effects.injected import make_cell
from tests.effects.test_catalogue import optional_columns


@pytest.fixture(scope="module")
def dataset():
    """Return a dataset whose poses were measured in another order than that of their numbers, which begin at 100."""
    cell = make_cell(seed=5, poses_per_plane=8, points_per_scan=6, columns=optional_columns).dataset
    poses = cell.poses.assign(pose=100 + np.arange(cell.n_poses))
    poses["order"] = 500 + np.random.default_rng(2).permutation(cell.n_poses)
    kept = [name for name in poses.columns if not re.match("step_|side_|wind_up|passing", name)]
    return replace(cell, poses=poses[kept])


def pose_of(dataset, order):
    """Return the number of the pose that was measured first at this order or later."""
    later = dataset.poses[dataset.poses["order"] >= order]
    return int(later.loc[later["order"].idxmin(), "pose"])


def test_every_effect_that_begins_at_a_pose_names_it(dataset):
    """Title, sentence and advice of each name the pose that has the order in their target; a title with it still means the same effect."""
    effects = every_effect(dataset, np.random.default_rng(6))
    begun = [effect for effect in effects if isinstance(effect.target.get("at"), dict)]
    begun = [replace(effect, order=float(dataset.poses["order"].sort_values().iloc[9])) for effect in begun]
    assert {effect.name for effect in begun} >= {"sensor_slip", "plane_moved", "target_drift"}
    for effect in begun:
        order = effect.target["at"]["order"]
        pose = pose_of(dataset, order)
        title = with_pose_numbers(effect.title, dataset)
        assert f", from pose {pose} (order {order:.0f}) on" in title
        assert f"pose {pose} (order {order:.0f})" in with_pose_numbers(effect.clause, dataset)
        assert f"from pose {pose} (order {order:.0f}) on" in with_pose_numbers(
            " ".join(effect.advice), dataset
        )
        as_before = title.replace(f"pose {pose} (order {order:.0f})", f"order {order:.0f} (pose {pose})")
        for written in (title, as_before):
            (again,) = parse_effects(written, dataset)
            assert again.key == parse_effects(effect.title, dataset)[0].key
        assert with_pose_numbers(title, dataset) == title


def test_other_orders_are_left_alone(dataset):
    """Orders of harmonics, places of a picture and orders after the last pose name no pose; an order between two poses has the next one."""
    for text in ("joint 4: harmonic error, order 503", "order 503", "from order 9999 on", "from pose 3 on"):
        assert with_pose_numbers(text, dataset) == text
    gap = replace(dataset, poses=dataset.poses.assign(order=2 * dataset.poses["order"]))
    pose = pose_of(gap, 1009)
    assert with_pose_numbers("near order 1009", gap) == f"near pose {pose} (order 1009)"


@pytest.mark.slow
def test_a_diagnosis_names_the_pose_of_a_slip_on_terminal_and_page():
    """The answer on the terminal, the report and the line of a fleet's table name the number of the first pose after the slip."""
    cell, _, target = slip(1, poses_per_plane=30, points_per_scan=20)
    n = cell.dataset.n_poses
    poses = cell.dataset.poses.assign(pose=100 + np.arange(n), order=np.arange(n))
    numbered = replace(cell.dataset, poses=poses)
    found = diagnose(numbered)
    (at,) = [
        entry["target"]["at"] for entry in found.to_mapping()["effects"] if entry["name"] == "sensor_slip"
    ]
    assert abs(at["order"] - target["order"]) <= 1
    named = f"from pose {pose_of(found.dataset, at['order'])} (order {at['order']:.0f}) on"
    for text in (describe_diagnosis(found), render_report(found), row_of(found)["effects"]):
        assert named in text
