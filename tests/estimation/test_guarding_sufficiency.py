"""Thresholds by which data are refused: each is tested with data on both sides of it, so that half or double the threshold changes the decision."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from scalar.errors import InvalidInput, ScalarError, Undetermined
from scalar.estimation.calibrate import calibrate
from scalar.estimation.conclude import _check_plausible
from scalar.estimation.settings import DEFAULTS, changed
from scalar.estimation.sufficiency import check_guess, check_lines, check_span
from scalar.geometry.planes import Planes
from scalar.units import DEG, MM
from tests.random_scene import make_scene

SUFFICIENT = DEFAULTS.sufficiency


def planes(*normals: Any) -> Planes:
    """Return planes of some normals."""
    unit = np.array([np.array(n) / np.linalg.norm(n) for n in normals])
    return Planes.at([f"plane {k}" for k in range(len(unit))], unit, np.ones(len(unit)))


def test_planes_nearly_parallel_are_refused():
    """A third plane at ten degrees to another one is enough with the limit, and not with twice the limit, unless there are said to be no more."""
    model: Any = SimpleNamespace(target=planes((0, 0, 1), (1, 0, 0), (1, np.tan(10 * DEG), 0)))
    residuals: Any = SimpleNamespace(measurement=SimpleNamespace(needs_spanning_planes=True))
    left = float(np.linalg.svd(model.target.normals, compute_uv=False)[-1])
    assert SUFFICIENT.least_span < left < 2 * SUFFICIENT.least_span
    dataset: Any = SimpleNamespace(few_planes=False)
    check_span(dataset, residuals, model)
    stricter = replace(SUFFICIENT, least_span=2 * SUFFICIENT.least_span)
    with pytest.raises(Undetermined, match="span only two directions"):
        check_span(dataset, residuals, model, stricter)
    check_span(SimpleNamespace(few_planes=True), residuals, model, stricter)  # type: ignore[arg-type]


def test_a_guess_far_from_its_plane_is_refused():
    """A guess that is 45 degrees off is accepted with a limit of sixty, and refused with thirty."""
    model: Any = SimpleNamespace(target=planes((0, 0, 1)))
    guess = planes((0, 1, 1))
    check_guess(model, guess)
    with pytest.raises(InvalidInput, match="45 degrees"):
        check_guess(model, guess, replace(SUFFICIENT, farthest_guess=SUFFICIENT.farthest_guess / 2))


@pytest.mark.parametrize(
    ("width", "sigma", "name"), [(1.5 * MM, 1e-5, "least_width"), (1.5 * MM, 2e-4, "least_width_sigmas")]
)
def test_a_plane_scanned_on_one_line_is_refused(width, sigma, name):
    """A strip of a metre by 1.5 mm determines a plane by default, and is a line if twice the width or certainty is asked for."""
    rng = np.random.default_rng(0)
    points = rng.standard_normal((500, 3)) * [1.0, width, 0.0]
    spread = np.ones(500), points, np.zeros((500, 0, 3))
    measurement = SimpleNamespace(
        scatter_in_base=lambda T: spread, target_index=np.zeros(500, dtype=int), sigma=sigma
    )
    residuals: Any = SimpleNamespace(
        measurement=measurement, kinematics=lambda model: SimpleNamespace(T_base_sensor=None)
    )
    model: Any = SimpleNamespace(target=planes((0, 0, 1)))
    check_lines(residuals, model)
    with pytest.raises(Undetermined, match="lie on a line"):
        check_lines(residuals, model, replace(SUFFICIENT, **{name: 2 * getattr(SUFFICIENT, name)}))


@pytest.mark.parametrize(
    ("row", "by", "name"), [(0, 0.7, "largest_length_change"), (1, 2.0, "largest_angle_change")]
)
def test_a_robot_that_no_workshop_builds_is_refused(row, by, name):
    """A length 0.7 m or an angle 2 rad off is refused with limits of half a metre and a quarter turn, and not with twice these limits."""
    nominal = make_scene(seed=1, poses_per_plane=3).dataset.robot
    geometry = nominal.geometry.copy()
    geometry[row, 2] += by
    model: Any = SimpleNamespace(robot=nominal.with_geometry(geometry), nominal=nominal)
    with pytest.raises(Undetermined, match="away from its nominal value"):
        _check_plausible(model, DEFAULTS.fit)
    _check_plausible(model, replace(DEFAULTS.fit, **{name: 2 * getattr(DEFAULTS.fit, name)}))


def test_a_pose_far_off_after_the_fit_is_a_gross_error():
    """A scan 25 mm behind its plane is refused by default, and accepted if so much is no gross error."""
    dataset = make_scene(seed=3, poses_per_plane=25, points_per_scan=10).dataset
    points = dataset.points.copy()
    scan = slice(dataset.starts[7], dataset.starts[8])
    points[scan] *= 1.0 + 0.03 / np.linalg.norm(points[scan], axis=1)[:, None]
    dataset = replace(dataset, points=points)
    with pytest.raises(ScalarError):
        calibrate(dataset)
    calibrate(dataset, settings=changed(DEFAULTS, {"sufficiency.gross_error": 0.1}))
