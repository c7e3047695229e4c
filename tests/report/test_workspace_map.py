"""The map of the error over the workspace: its cells, its colours, and what it says."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scalar.cli.diagnosis_words import describe_diagnosis
from scalar.data.poses import Poses
from scalar.diagnosis import diagnose
from scalar.estimation.calibrate import calibrate
from scalar.estimation.result import Calibration
from scalar.evaluate.workspace_errors import aligned_errors
from scalar.geometry.robot import Robot
from scalar.report import render_calibration
from scalar.report.workspace_cells import means_of
from scalar.report.workspace_map import SHIPPED, _edges, workspace_section
from tests.calibrated_arms import calibrated
from tests.random_scene import make_scene
from tests.robot_configs import robot_mapping


def uncertain(robot: Robot, size: float = 1e-4) -> Calibration:
    """Return a calibration whose geometry is uncertain."""
    found = calibrated(robot, np.random.default_rng(2))
    free = tuple(name for name in found.model.names if name.split("_")[0] in ("a", "d", "alpha", "theta"))
    return replace(found, free=free, covariance=size**2 * np.eye(len(free)))


@pytest.fixture(scope="module")
def section() -> dict:
    """Return the section of an arm that is a millimetre off."""
    calibration = uncertain(Robot.from_mapping(robot_mapping("panda")))
    rng = np.random.default_rng(1)
    n = calibration.model.nominal.n_joints
    seen = Poses(rng.uniform(-1.0, 1.0, (30, n)), np.arange(30.0), {})
    found = workspace_section(calibration, None, seen, SHIPPED)
    assert found is not None
    return found


@given(st.floats(1e-5, 1.0), st.floats(1.0, 1e5))
def test_classes_of_colour_are_round_and_hold_every_value(smallest: float, ratio: float) -> None:
    """There are nine rising edges of one digit, of which the last alone reaches the largest value.

    Within four decades the smallest value has a class of its own.
    """
    largest = smallest * ratio
    edges = _edges(smallest, largest)
    assert len(edges) == 9 and np.all(np.diff(edges) > 0)
    assert edges[-2] < largest <= edges[-1] * (1 + 1e-12)
    assert all(re.fullmatch(r"[1235]\.0+e.*", f"{edge:.12e}") for edge in edges)
    if 30 < ratio < 1e4:
        assert np.searchsorted(edges, smallest) < np.searchsorted(edges, largest)


def test_a_cell_has_the_mean_of_its_poses() -> None:
    """The mean of each draw in a cell is that of a data frame's groups."""
    rng = np.random.default_rng(0)
    cell, draws = rng.integers(0, 7, 200), rng.normal(size=(5, 200))
    expected = pd.DataFrame(draws.T).groupby(cell).mean().to_numpy().T
    np.testing.assert_allclose(means_of(draws, cell, 7), expected, atol=1e-14)


def test_what_is_shipped_has_the_smaller_error(section: dict) -> None:
    """By the data sheet the arm errs by about a millimetre, as it was made, and by the estimate only by what the covariance leaves."""
    assert [row["state"] for row in section["rows"]] == ["data sheet", "after.json"]
    before, after = (float(row["mean"]["value"].removesuffix(" mm")) for row in section["rows"])
    assert 0.3 < before < 5.0 and after < 0.3 * before
    for row in section["rows"]:
        for entry in (row["mean"], row["most"]):
            low, high = map(float, entry["band"].removesuffix(" mm").split(" to "))
            assert low <= float(entry["value"].removesuffix(" mm")) <= high


def test_each_cell_says_its_error_and_its_band(section: dict) -> None:
    """Every cell of the two slices can be pointed at, before and after, and tells where it is, its error and the band."""
    said = r"<title>about (\S+) m, (\S+) m: mean error (\S+) mm, 95 % band (\S+) to (\S+) mm \((\d+) poses\)"
    for picture in section["pictures"][:2]:
        before, after = (re.findall(said, markup) for markup in (picture.before, picture.after))
        assert len(before) == len(after) > 30
        assert {cell[:2] for cell in before} == {cell[:2] for cell in after}
        assert sum(int(cell[5]) for cell in before) > 3000
    side = section["pictures"][0]
    assert all(float(r) >= 0 for r, *_ in re.findall(said, side.before))


def test_before_and_after_show_the_same_quantity(section: dict) -> None:
    """The colour of a cell is the class of its mean error, before as after; the upper ends of the bands stand in maps of their own, both as well."""
    cell = r"mean error (\S+) mm, 95 % band \S+ to (\S+) mm"
    for picture in section["pictures"][:4]:
        upper = picture in section["pictures"][2:4]
        class_of = {colour: text for _, colour, text in picture.key}
        for markup in (picture.before, picture.after):
            # The marks of one colour are one group.
            _, *groups = re.split(r'fill: var\(--(\w+)\)" class="dots">', markup)
            coloured = zip(groups[::2], groups[1::2], strict=True)
            found = [(colour, *one) for colour, marks in coloured for one in re.findall(cell, marks)]
            assert len(found) > 30
            for colour, value, high in found:
                edges = re.fullmatch(r"(?:below|(\S+) to) (\S+) mm", class_of[colour])
                low, top = map(float, edges.groups(default="0"))
                # The text has two digits, so that a value at an edge may be rounded beyond it.
                assert 0.94 * low <= float(high if upper else value) <= 1.06 * top
    assert "97.5 %" not in section["pictures"][0].after and "97.5 %" in section["pictures"][2].caption
    assert "before, at most" in section["pictures"][2].before


def test_the_page_of_a_calibration_begins_with_the_error_and_what_to_do() -> None:
    """The page begins with the errors by data sheet and as calibrated, and the command that uses it.

    It has the same bytes each time, and is under a megabyte.
    """
    scene = make_scene(kind="tracker", seed=2, poses_per_plane=12)
    calibration = calibrate(scene.dataset)
    page = render_calibration(calibration, scene.dataset)
    first, second = re.findall(r'<p class="lead">(.*?)</p>', page)
    before, after = map(float, re.findall(r"errs by (\S+) mm", first))
    assert after < before / 3 and "scalar correct calibration.json" in second
    assert page == render_calibration(calibration, scene.dataset) and len(page.encode()) < 1e6
    assert "<script" not in page and "http:" not in page and "https:" not in page


@pytest.mark.parametrize("kind", ["tracker", "line-laser"])
def test_what_the_model_lacks_is_counted_in_the_error(kind: str) -> None:
    """If a gear errs with three times the angle of joint 2 and the model lacks the effect, the page states the arm's error within a factor of two.

    The covariance alone leaves a far smaller one.
    """
    scene = make_scene(kind=kind, seed=2, poses_per_plane=30, points_per_scan=20, noise=2e-5)
    q_true = scene.dataset.q.copy()
    read = q_true.copy()
    for _ in range(20):  # q_true = read + error(read)
        read[:, 1] = q_true[:, 1] - gear(read[:, 1])
    dataset = replace(scene.dataset, poses=scene.dataset.poses.assign(q2=read[:, 1]))
    calibration = calibrate(dataset)
    q = np.random.default_rng(3).uniform(*dataset.robot.limits.T, (2000, 6))
    moved = q.copy()
    moved[:, 1] += gear(q[:, 1])
    T_hat, T_true = calibration.predict(q), scene.truth.sensor(moved)
    errs = float(np.mean(np.linalg.norm(aligned_errors(T_hat, T_true), axis=1))) * 1e3
    first, second = re.findall(r'<p class="lead">(.*?)</p>', render_calibration(calibration, dataset))
    _, after = map(float, re.findall(r"errs by (\S+) mm", first))
    assert errs / 2 < after < 2 * errs
    assert "beyond the noise would alone make" in first and "scalar diagnose" in second


def test_a_scale_that_nothing_shows_is_counted_in_the_error() -> None:
    """A probe on planes of unknown place shows no length, and by the data sheet this arm is 0.05 % smaller than it is. The page says so, and its
    band holds the error that the arm then has, of which the covariance knows a small part."""
    scene = make_scene(kind="probe", seed=2, poses_per_plane=30, noise=2e-5)
    robot = scene.dataset.robot
    scale = np.array([[1 - 5e-4], [1.0], [1 - 5e-4], [1.0], [1.0]])  # a, alpha, d, theta, beta
    dataset = replace(scene.dataset, robot=replace(robot, geometry=robot.geometry * scale))
    calibration = calibrate(dataset)
    q = np.random.default_rng(3).uniform(*robot.limits.T, (2000, 6))
    errors = aligned_errors(calibration.predict(q), scene.truth.sensor(q))
    errs = float(np.mean(np.linalg.norm(errors, axis=1))) * 1e3
    assert "no length is known" in describe_diagnosis(diagnose(dataset))
    page = render_calibration(calibration, dataset)
    low, high = map(float, re.findall(r"errs by \S+ mm \((\S+) to (\S+) mm\)", page)[0])
    assert low < errs < high and "every length is relative to" in page


def gear(angle: np.ndarray) -> np.ndarray:
    """Return the error of a joint [rad]."""
    return 4e-4 * np.sin(3 * angle)


def test_an_arm_on_the_wall_is_seen_from_the_side_of_gravity() -> None:
    """With gravity along the base's x, heights are along x: the labels no longer speak of the base's own x and y."""
    robot = replace(Robot.from_mapping(robot_mapping("panda")), gravity=np.array([-9.81, 0.0, 0.0]))
    seen = Poses(np.random.default_rng(1).uniform(-1, 1, (9, robot.n_joints)), np.arange(9.0), {})
    calibration = uncertain(robot)
    found = workspace_section(calibration, None, seen, SHIPPED)
    assert found is not None
    assert (
        "horizontally [m]" in found["pictures"][1].before
        and "y of the base" not in found["pictures"][1].before
    )


@pytest.mark.parametrize("joints", [1, 2])
def test_an_arm_that_fills_no_slice_is_no_error(joints: int) -> None:
    """One joint about the vertical errs by nothing that its base does not take up; two parallel ones move in a plane, and are drawn."""
    rows = [{"a": 0.3 * (k > 0), "alpha": 0.0, "d": 0.1, "theta": 0.0} for k in range(joints)]
    calibration = uncertain(Robot.from_mapping({"name": "arm", "joints": rows}))
    seen = Poses(np.zeros((4, joints)), np.arange(4.0), {})
    found = workspace_section(calibration, None, seen, SHIPPED)
    assert found is None if joints == 1 else found is not None and len(found["pictures"]) == 5


def test_a_model_that_is_exact_has_no_map() -> None:
    """If nothing errs and nothing is uncertain, there is no map."""
    calibration = Calibration.nominal(make_scene(kind="tracker", poses_per_plane=3).dataset)
    seen = Poses(np.zeros((4, 6)), np.arange(4.0), {})
    assert workspace_section(calibration, None, seen, SHIPPED) is None
