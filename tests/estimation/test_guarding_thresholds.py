"""Thresholds against what good data do not have: halved or doubled, each decides otherwise on data made for it.

``snakemake sensitivity`` names these tests for thresholds that no blind set puts to the test.
"""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from scalar.errors import InvalidInput, ScalarError, Undetermined
from scalar.estimation import outlying_points, plane_labels
from scalar.estimation.calibrate import calibrate
from scalar.estimation.conclude import _check_plausible
from scalar.estimation.data_sheet_priors import fit_near_data_sheet, misfit_ratio, prior_std, with_reasons
from scalar.estimation.geometry_fit import geometry_fit
from scalar.estimation.gross_errors import clean, clean_given_effects
from scalar.estimation.identifiability import _null_space_of_scaled
from scalar.estimation.outlying_points import without_outlying_points
from scalar.estimation.plane_labels import other_labels
from scalar.estimation.pose_consistency import (
    _core,
    _heavy_tailed,
    coarsely_consistent,
    in_runs,
    outlier_limit,
)
from scalar.estimation.settings import DEFAULTS, changed
from scalar.estimation.sufficiency import check_guess, check_lines, check_span
from scalar.geometry.planes import Planes
from scalar.sensors.robust_scale import robust_std
from scalar.units import DEG, MM
from tests import helpers

GROSS, SUFFICIENT = DEFAULTS.gross_errors, DEFAULTS.sufficiency


def scans(points_per_scan: int = 20, noise: float = 1e-5, off: dict[int, float] | None = None) -> Any:
    """Return a dataset of nine scans, some points of the first moved along z.

    Args:
        points_per_scan: Of each. noise: [m]. off: ``{point: by how much [m]}``.
    """
    dataset = helpers.make_scene(
        seed=1, poses_per_plane=3, points_per_scan=points_per_scan, noise=noise
    ).dataset
    points = dataset.points.copy()
    for point, by in (off or {}).items():
        points[point, 1] += by
    return replace(dataset, points=points)


def test_a_point_nearer_than_the_least_error_stays_however_quiet_its_scan():
    """0.3 mm off a scan with 10 micrometres of noise: set aside beyond 0.2 mm, kept below 0.4 mm."""
    dataset = scans(off={5: 0.3 * MM})
    assert without_outlying_points(dataset, GROSS)[1] == 1
    assert (
        without_outlying_points(dataset, replace(GROSS, least_point_error=2 * GROSS.least_point_error))[1]
        == 0
    )


def test_a_short_scan_has_no_outlying_points():
    """Seven points, one of them far off: enough with five, too few with ten."""
    dataset = scans(points_per_scan=7, off={3: 5 * MM})
    assert without_outlying_points(dataset, GROSS)[1] == 1
    assert without_outlying_points(dataset, replace(GROSS, least_points=2 * GROSS.least_points))[1] == 0


def test_a_scan_with_many_points_off_its_line_is_corrupted():
    """Five of twenty points off: dropped where a third may be, the whole scan where a sixth may."""
    dataset = scans(off=dict.fromkeys((2, 6, 11, 13, 17), 5 * MM))
    _, dropped, corrupted = without_outlying_points(dataset, GROSS)
    assert dropped == 5 and not corrupted.any()
    _, dropped, corrupted = without_outlying_points(
        dataset, replace(GROSS, corrupted_share=GROSS.corrupted_share / 2)
    )
    assert dropped == 0 and list(np.flatnonzero(corrupted)) == [0]


def test_a_line_is_found_among_strays_by_reweighting(monkeypatch):
    """Six of twenty points at one end, all off to one side: one round of reweighting is led astray, the usual number is not."""
    dataset = scans(off=dict.fromkeys(range(6), 10 * MM))
    assert without_outlying_points(dataset, GROSS)[1] == 6
    monkeypatch.setattr(outlying_points, "_ROUNDS", 1)
    assert without_outlying_points(dataset, GROSS)[1] != 6


def test_a_pose_far_off_the_nominal_arm_is_left_out_at_first():
    """A scan 30 mm behind its plane, with an arm that is right: out beyond 20 mm, in below 40 mm."""
    dataset = helpers.make_scene(
        seed=2,
        poses_per_plane=12,
        points_per_scan=10,
        length_error=0.0,
        angle_error=0.0,
        pose_offset=(0.0, 0.0),
    ).dataset
    points = dataset.points.copy()
    scan = slice(dataset.starts[4], dataset.starts[5])
    points[scan] *= 1 + 30 * MM / np.linalg.norm(points[scan], axis=1)[:, None] / 0.8
    dataset, everything = replace(dataset, points=points), np.ones(dataset.n_poses, dtype=bool)
    assert list(np.flatnonzero(~coarsely_consistent(dataset, everything, GROSS))) == [4]
    loose = replace(GROSS, coarse_pose_error=2 * GROSS.coarse_pose_error)
    assert coarsely_consistent(dataset, everything, loose).all()


@pytest.mark.parametrize(
    ("length", "n_off", "name", "value"),
    [(5, 5, "contiguous_run", 8), (5, 20, "run_by_chance", 0.05 / 20)],
)
def test_successive_poses_that_are_all_off_are_a_change(length, n_off, name, value):
    """Five in a row of one plane: a change where four are enough and chance makes no such run, else outliers."""
    dataset = SimpleNamespace(plane_index=np.zeros(100, dtype=int))
    off = np.zeros(100, dtype=bool)
    off[40 : 40 + length] = True
    off[np.arange(n_off - length) * 2 + 50] = True
    assert list(np.flatnonzero(in_runs(dataset, off, GROSS))) == list(range(40, 40 + length))  # type: ignore[arg-type]
    assert not in_runs(dataset, off, replace(GROSS, **{name: value})).any()  # type: ignore[arg-type]


def test_a_few_distances_far_above_most_say_that_the_fit_was_dragged():
    """One of a hundred poses 25 times as far off as the others: two and a half times the median in the mean square, above two, below four."""
    distances = np.r_[np.full(99, 1e-4), 25e-4]
    assert _heavy_tailed(distances, GROSS)
    assert not _heavy_tailed(distances, replace(GROSS, heavy_tail=2 * GROSS.heavy_tail))


def test_a_direction_that_only_rounding_shows_is_none():
    """Of three columns, two differ by 1.5e-8 of their length: a direction above 1e-8, none below 2e-8."""
    first, other, third = np.linalg.qr(np.random.default_rng(0).standard_normal((30, 3)))[0].T
    J = np.column_stack([first, first + 3e-8 * other, third])
    tolerance = DEFAULTS.identifiability.null_tolerance
    assert _null_space_of_scaled(J, tolerance)[1].shape[1] == 0
    assert _null_space_of_scaled(J, 2 * tolerance)[1].shape[1] == 1


@pytest.fixture(scope="module")
def labelled() -> Any:
    """Return a set with one wrong label, and which poses are right."""
    dataset = helpers.make_scene(seed=3, poses_per_plane=20, points_per_scan=10).dataset
    plane = dataset.poses["plane"].to_numpy(dtype=object).copy()
    plane[7] = next(name for name in dict.fromkeys(plane) if name != plane[7])
    keep = np.arange(dataset.n_poses) != 7
    return replace(dataset, poses=dataset.poses.assign(plane=plane)), keep


def test_a_pose_is_mislabelled_only_where_another_plane_is_far_nearer(labelled, monkeypatch):
    """0.9 mm from another plane and 6 mm from its own: mislabelled. 3 mm from its own: not."""
    dataset, keep = labelled
    assert list(other_labels(dataset, keep, [7], DEFAULTS)) == [7]
    names = list(dict.fromkeys(dataset.poses["plane"]))
    mine = names.index(dataset.poses["plane"][7])
    for own, labels in ((6 * MM, [7]), (3 * MM, [])):

        def distances(measurement: Any, T: Any, planes: Any, index: Any, own: float = own) -> Any:
            found = np.full(len(index), 0.05 * MM)
            found[7] = own if planes.names[index[7]] == names[mine] else 0.9 * MM
            return found

        monkeypatch.setattr(plane_labels, "pose_distances", distances)
        assert list(other_labels(dataset, keep, [7], DEFAULTS)) == labels


def test_the_better_part_of_a_planes_poses_is_more_than_half():
    """Six of ten: more than half, as least trimmed squares asks for, and no more than are right if a third is wrong."""
    dataset: Any = SimpleNamespace(plane_index=np.zeros(10, dtype=int))
    assert _core(dataset, np.arange(10.0), np.ones(10, dtype=bool), GROSS).sum() == 6


def test_how_far_off_a_pose_may_be():
    """Among poses that agree to micrometres, about a millimetre, which an arm that is not calibrated errs by; else ten times their scatter."""
    normal = np.abs(np.random.default_rng(0).standard_normal(1000))
    assert 0.7 * MM < outlier_limit(1e-6 * normal, GROSS) < 1.5 * MM
    scatter = robust_std(1e-3 * normal)
    assert 7 * scatter < outlier_limit(1e-3 * normal, GROSS) < 15 * scatter


def test_what_stands_out_late_is_few():
    """One of sixty poses 5 mm off given the effects: set aside where two in a hundred may be, kept where one may."""
    dataset = helpers.make_scene(seed=3, poses_per_plane=20, points_per_scan=4).dataset
    cleaned = SimpleNamespace(dataset=dataset, outlier_poses=())
    distance = np.full(60, 0.1 * MM)
    distance[30] = 5 * MM
    strict = replace(GROSS, most_late=GROSS.most_late / 2)
    assert clean_given_effects(cleaned, distance, strict) is cleaned  # type: ignore[arg-type]


def planes(*normals: Any) -> Planes:
    """Return planes of some normals."""
    unit = np.array([np.array(n) / np.linalg.norm(n) for n in normals])
    return Planes.at([f"plane {k}" for k in range(len(unit))], unit, np.ones(len(unit)))


def test_planes_nearly_parallel_are_refused():
    """A third plane that leans by fifteen degrees out of the span of the others: enough above ten degrees, too little above twenty."""
    model: Any = SimpleNamespace(target=planes((0, 0, 1), (1, 0, 0), (1, np.tan(15 * DEG), 0)))
    residuals: Any = SimpleNamespace(measurement=SimpleNamespace(needs_spanning_planes=True))
    left = float(np.linalg.svd(model.target.normals, compute_uv=False)[-1])
    assert SUFFICIENT.least_span < left < 2 * SUFFICIENT.least_span
    check_span(residuals, model)
    with pytest.raises(Undetermined, match="span only two directions"):
        check_span(residuals, model, replace(SUFFICIENT, least_span=2 * SUFFICIENT.least_span))


def test_a_guess_far_from_its_plane_is_refused():
    """A guess that is 45 degrees off: believed within sixty, refused beyond thirty."""
    model: Any = SimpleNamespace(target=planes((0, 0, 1)))
    guess = planes((0, 1, 1))
    check_guess(model, guess)
    with pytest.raises(InvalidInput, match="45 degrees"):
        check_guess(model, guess, replace(SUFFICIENT, farthest_guess=SUFFICIENT.farthest_guess / 2))


@pytest.mark.parametrize(
    ("width", "sigma", "name"), [(1.5 * MM, 1e-5, "least_width"), (1.5 * MM, 2e-4, "least_width_sigmas")]
)
def test_a_plane_scanned_on_one_line_is_refused(width, sigma, name):
    """A strip of a metre by 1.5 mm is a plane; with twice the width or seven of twice the standard deviations asked for, it is a line."""
    rng = np.random.default_rng(0)
    points = rng.standard_normal((500, 3)) * [1.0, width, 0.0]
    spread = np.ones(500), points, np.zeros((500, 0, 3))
    measurement = SimpleNamespace(
        spread_in_base=lambda T: spread, target_index=np.zeros(500, dtype=int), sigma=sigma
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
    """A length 0.7 m, or an angle 2 rad, off its nominal value: refused beyond half a metre and a quarter turn, not beyond twice that."""
    nominal = helpers.make_scene(seed=1, poses_per_plane=3).dataset.robot
    geometry = nominal.geometry.copy()
    geometry[row, 2] += by
    model: Any = SimpleNamespace(robot=nominal.with_geometry(geometry), nominal=nominal)
    with pytest.raises(Undetermined, match="away from its nominal value"):
        _check_plausible(model, DEFAULTS.fit)
    _check_plausible(model, replace(DEFAULTS.fit, **{name: 2 * getattr(DEFAULTS.fit, name)}))


def test_a_pose_far_off_after_the_fit_is_a_gross_error():
    """A scan 25 mm behind its plane: a calibration refuses it, and goes on where so much is no gross error."""
    dataset = helpers.make_scene(seed=3, poses_per_plane=25, points_per_scan=10).dataset
    points = dataset.points.copy()
    scan = slice(dataset.starts[7], dataset.starts[8])
    points[scan] *= 1.0 + 0.03 / np.linalg.norm(points[scan], axis=1)[:, None]
    dataset = replace(dataset, points=points)
    with pytest.raises(ScalarError):
        calibrate(dataset)
    calibrate(dataset, settings=changed(DEFAULTS, {"sufficiency.gross_error": 0.1}))


PRIORS = {
    "plausible_length": 5 * MM,
    "plausible_angle": 1 * DEG,
    "plausible_sensor_place": 50 * MM,
    "plausible_sensor_turn": 11.5 * DEG,
    "plausible_target": 10.0,
}
"""What is known of an arm before it is measured: its data sheet, a ruler, the eye; and of the target nothing."""


@pytest.fixture(scope="module")
def prepared() -> Any:
    """Return what a small set gives: its residuals, the model to start from, what is free, and the fit."""
    dataset = helpers.make_scene(seed=5, poses_per_plane=7, points_per_scan=10).dataset
    found, start = geometry_fit(dataset)
    return start.residuals, start.initial.model, start.free, found


@pytest.mark.parametrize("name", PRIORS)
def test_how_far_a_data_sheet_may_be_off_is_the_prior_of_its_kind(prepared, name):
    """Each is the prior standard deviation of its own parameters and of no others, and as wide as what it stands for."""
    model = prepared[1]
    settings = DEFAULTS.identifiability
    before = prior_std(model, settings)
    after = prior_std(model, replace(settings, **{name: 2 * getattr(settings, name)}))
    changed_names = {model.names[i] for i in np.flatnonzero(after != before)}
    np.testing.assert_array_equal(after[after != before], 2 * before[after != before])
    np.testing.assert_allclose(before[after != before], PRIORS[name], rtol=0.01)
    kinds = {
        "plausible_length": lambda n: n.startswith(("a_", "d_")),
        "plausible_angle": lambda n: n.startswith(("alpha_", "theta_", "beta_")),
        "plausible_sensor_place": lambda n: n in ("sensor_x", "sensor_y", "sensor_z"),
        "plausible_sensor_turn": lambda n: n.startswith("sensor_r"),
        "plausible_target": lambda n: model.names.index(n) >= model.blocks["target"].start,
    }
    assert changed_names == {n for n in model.names if kinds[name](n)}


def test_few_equations_do_not_say_how_large_the_noise_is(prepared):
    """Twenty-one poses leave between ten and twenty degrees of freedom: a residual above the stated noise counts where ten are enough."""
    residuals, _, free, found = prepared
    few = DEFAULTS.identifiability.enough_to_judge
    freedom = int(residuals.measurement.equations.sum()) - int(free.sum())
    assert few <= freedom < 2 * few
    louder = replace(
        residuals, measurement=replace(residuals.measurement, sigma=residuals.measurement.sigma / 50)
    ).reweighted(found)
    assert misfit_ratio(louder, found, free) > 10
    asked_for_more = changed(DEFAULTS, {"identifiability.enough_to_judge": 2 * few})
    assert misfit_ratio(louder, found, free, asked_for_more) == 1.0


def test_priors_are_kept_where_a_direction_is_known_no_better_than_asked(prepared):
    """Priors stay while some standard error is above the stated share of its prior, and are left out once none is."""
    residuals, model, free, _ = prepared
    kept = fit_near_data_sheet(
        residuals, model, free, changed(DEFAULTS, {"identifiability.prior_matters": 1e6})
    )
    left_out = fit_near_data_sheet(
        residuals, model, free, changed(DEFAULTS, {"identifiability.prior_matters": 1e-6})
    )
    assert len(kept.priors) > 0 and not left_out.priors
    told = [
        sum(
            bool(p.reason)
            for p in with_reasons(
                residuals, kept, free, replace(DEFAULTS.identifiability, prior_decides=share)
            ).priors
        )
        for share in (1e-6, 0.999999)
    ]
    assert told[0] > told[1]


def test_a_third_of_the_poses_must_not_be_set_aside_where_a_fifth_may(labelled):
    """Labels of a quarter of the poses are wrong: survived where nearly half may be set aside, refused where less than a quarter may."""
    dataset, _ = labelled
    plane = dataset.poses["plane"].to_numpy(dtype=object).copy()
    names = list(dict.fromkeys(plane))
    for i in range(0, 60, 4):
        plane[i] = names[(names.index(plane[i]) + 1) % 3]
    wrong = replace(dataset, poses=dataset.poses.assign(plane=plane))
    assert len(clean(wrong).mislabelled_poses) >= 15
    with pytest.raises(Undetermined):
        clean(wrong, changed(DEFAULTS, {"gross_errors.most_set_aside": GROSS.most_set_aside / 2}))
