"""Sweeps: the dataset in memory is the one on disk, plans are nested, the bound is a bound, every fit is counted."""

import numpy as np
import pandas as pd
import pytest
from study.common.bound import bound_errors
from study.common.grid import with_overrides
from study.common.in_memory import dataset_in_memory
from study.sweeps.plans import read_plans, serves, write_plans
from study.sweeps.run import SWEEP_COLUMNS, sweep_cases
from study.sweeps.summary import join_cases, place_published_curve, summarise_sweep

from scalar.data.dataset import read_dataset
from scalar.simulation.config import load_config
from scalar.simulation.export import write_scene
from scalar.simulation.scene import simulate

SCENE = "configs/scenes/paper.yaml"
SMALL = {"poses_per_plane": 12, "sensor.points_per_scan": 20, "truth_poses": 200}


@pytest.fixture(scope="module")
def plans(tmp_path_factory, repository):
    """Return a file of the postures of two seeds, more than a small case asks for."""
    path = tmp_path_factory.mktemp("plans") / "plans.npz"
    write_plans(repository / SCENE, 14, [1, 2], path)
    return path


@pytest.fixture(scope="module")
def repository(request):
    """Return the checkout."""
    return request.config.rootpath


def small_scene(repository, **overrides):
    """Return a small scene of the paper's workcell."""
    config = with_overrides(load_config(repository / SCENE), SMALL | overrides)
    return config, simulate(config, base_dir=(repository / SCENE).parent)


def test_the_dataset_in_memory_is_the_one_that_is_read_back(tmp_path, repository):
    """The dataset in memory equals the one that is written and read back, in everything that a calibration uses."""
    _, scene = small_scene(repository)
    write_scene(scene, tmp_path, table_format="parquet")
    there, here = read_dataset(tmp_path / "dataset"), dataset_in_memory(scene)
    assert np.array_equal(there.points, here.points)
    assert np.array_equal(there.starts, here.starts)
    assert np.allclose(there.q, here.q, rtol=0, atol=1e-12)
    assert np.array_equal(there.plane_index, here.plane_index)
    assert np.allclose(there.robot.geometry, here.robot.geometry, rtol=0, atol=1e-15)
    assert np.allclose(there.sensor.T_flange_sensor, here.sensor.T_flange_sensor, rtol=0, atol=1e-15)
    assert (there.sensor.noise, there.sensor.error_axis) == (here.sensor.noise, here.sensor.error_axis)
    for a, b in zip(there.planes, here.planes, strict=True):
        assert a.name == b.name
        assert np.allclose([*a.normal, a.distance], [*b.normal, b.distance], rtol=0, atol=1e-15)


def test_a_shared_plan_gives_the_poses_that_the_case_would_find_itself(plans, repository):
    """A longer plan begins with the shorter one, so sharing changes nothing."""
    config, alone = small_scene(repository)
    plan = read_plans(plans)[config["seed"]].plan
    assert serves(plan, config)
    shared = simulate(config, base_dir=(repository / SCENE).parent, plan=plan)
    assert np.array_equal(alone.points, shared.points)
    assert not serves(plan, config | {"poses_per_plane": 41})
    assert not serves(plan, config | {"edge_margin_m": 0.02})


@pytest.mark.parametrize(
    ("overrides", "cast_anew"),
    [
        ({}, False),
        ({"poses_per_plane": 6, "sensor.points_per_scan": 1}, False),
        ({"noise.range_noise_std_m": 1e-3, "plane_guess.tilt_deg": 20}, False),
        ({"sensor.points_per_scan": 150}, True),
        ({"sensor.rays": 100, "sensor.points_per_scan": 100}, True),
        ({"noise.joint_noise_std_rad": 1e-4}, True),
    ],
)
def test_shared_scans_change_no_bit(plans, repository, monkeypatch, overrides, cast_anew):
    """Points that are taken from the plan are those that are cast anew, and points that the plan lacks are cast."""
    from scalar.simulation import ranges

    config, alone = small_scene(repository, **overrides)
    shared, calls, cast = read_plans(plans)[config["seed"]], [], ranges.cast_fan
    monkeypatch.setattr(ranges, "cast_fan", lambda *args: calls.append(1) or cast(*args))
    again = simulate(config, base_dir=(repository / SCENE).parent, plan=shared.plan, cast=shared.scans)
    assert bool(calls) == cast_anew
    assert np.array_equal(alone.points, again.points)
    assert np.array_equal(alone.T_base_sensor, again.T_base_sensor)


def test_the_bound_is_proportional_to_the_noise(repository):
    """The bound is proportional to the noise, and without noise there is none."""
    held = load_config(repository / SCENE)["initial_model"]["exact"]
    found = []
    for noise in (1e-6, 1e-5):
        _, scene = small_scene(repository, **{"noise.range_noise_std_m": noise})
        found.append(bound_errors(dataset_in_memory(scene), scene.truth, held, scene.truth_poses))
    for fine, coarse in zip(*found, strict=True):  # expected, and with this noise, whose pattern is the same
        assert np.allclose([coarse[name] / fine[name] for name in fine], 10.0, rtol=0.01)
    _, unobservable = small_scene(repository, **{"noise.range_noise_std_m": 0})
    assert (
        bound_errors(dataset_in_memory(unobservable), unobservable.truth, held, unobservable.truth_poses)
        is None
    )


def test_a_calibration_at_the_bound_has_the_error_of_the_efficient_estimate(plans, repository):
    """With small noise our estimate is the efficient one seed by seed, and over seeds it scatters as the bound says."""
    overrides = SMALL | {"noise.range_noise_std_m": 1e-6}
    table = sweep_cases(
        {"fine": overrides}, {"upright": repository / SCENE}, [1, 2], ["proposed"], {"upright": plans}
    )
    raw = table[table["alignment"] == "raw"].set_index(["method", "seed"])[["position_mean_mm"]]
    ratio = raw.loc["proposed"] / raw.loc["efficient"]
    assert np.allclose(ratio, 1.0, rtol=2e-3)
    assert (raw.loc["efficient"] / raw.loc["cramer-rao"]).to_numpy() == pytest.approx(1.0, abs=0.9)


def test_there_is_no_bound_with_fewer_equations_than_unknowns(repository):
    """Fifteen poses give thirty equations for thirty-two unknowns, so there is no bound."""
    held = load_config(repository / SCENE)["initial_model"]["exact"]
    _, scene = small_scene(repository, poses_per_plane=5)
    assert bound_errors(dataset_in_memory(scene), scene.truth, held, scene.truth_poses) is None


def test_a_stated_tolerance_calibrates_where_equations_are_too_few(plans, repository):
    """Fifteen poses are refused without a tolerance, and calibrated to better than the initial model with one; thirty-six need none."""
    methods = ["proposed", "proposed-tolerance"]
    cases = {"few": SMALL | {"poses_per_plane": 5}, "enough": SMALL}
    table = sweep_cases(cases, {"upright": repository / SCENE}, [1, 2], methods, {"upright": plans})
    raw = table[table["alignment"] == "raw"].set_index(["case", "method"]).sort_index()
    assert set(raw.loc[("few", "proposed"), "status"]) == {"undetermined"}
    few = raw.loc[("few", "proposed-tolerance"), "position_mean_mm"].mean()
    assert few < 0.8 * raw.loc[("few", "initial"), "position_mean_mm"].mean()
    enough = [raw.loc[("enough", method), "position_mean_mm"].to_numpy() for method in methods]
    assert np.allclose(*enough, rtol=0.01)


def test_a_fit_that_fails_is_a_row_and_is_counted(plans, repository):
    """Refused and raised fits stay in the table, and the summary counts each once."""
    methods = ["baseline-raise", "proposed"]
    scenes, shared = {"upright": repository / SCENE}, {"upright": plans}
    table = sweep_cases({"few": SMALL | {"poses_per_plane": 5}}, scenes, [1, 2], methods, shared)
    assert list(table.columns) == list(SWEEP_COLUMNS)
    assert len(table) == 2 * 3 * 2  # seeds, initial model and methods, alignments; no bound
    errors = join_cases([table], {"few": 15.0})
    summary = summarise_sweep(errors).set_index(["method", "alignment", "quantity"])
    refused = summary.loc[("proposed", "raw", "position_mean_mm")]
    assert (refused["seeds"], refused["failed"], refused["refused"]) == (2, 2, 2)
    assert np.isnan(refused["median"])
    raised = summary.loc[("baseline-raise", "raw", "position_mean_mm")]
    assert (raised["failed"], raised["raised"], raised["refused"]) == (2, 2, 0)


def test_a_published_point_is_placed_among_the_seeds_of_its_own_case():
    """A published point lies inside if it is within the simulated range; points without a simulated case have no row."""
    names = ("position_mean_mm", "position_max_mm", "orientation_mean_deg", "orientation_max_deg")
    ours = [
        {
            "walls": "upright",
            "value": 0.1 * k,
            "method": "proposed",
            "status": "converged",
            "alignment": "raw",
        }
        | dict.fromkeys(names, error)
        for k in (1, 2)
        for error in (1.0, 2.0, 3.0, 4.0)
    ]
    curve = pd.DataFrame(
        [{"value": 0.1, **dict.fromkeys(names, 2.5)}, {"value": 0.3, **dict.fromkeys(names, 2.5)}]
    )
    placed = place_published_curve(pd.DataFrame(ours), curve)
    assert len(placed) == len(names)
    assert placed["inside_band"].all()
    assert placed["inside_range"].all()
    assert (placed["percentile"] == 50.0).all()


def test_readings_of_the_root_agree_where_it_is_never_negative(tmp_path, repository):
    """On tilted walls a reading that is taken over from another is the one that it would have found itself."""
    scene, own = "configs/scenes/paper_tilted.yaml", tmp_path / "plans.npz"
    write_plans(repository / scene, 12, [1], own)
    tables = [
        sweep_cases(
            {"tilted": SMALL}, {"leaning": repository / scene}, [1], methods, {"leaning": own}
        ).set_index(["method", "alignment"])
        for methods in (["baseline-clip", "baseline-raise"], ["baseline-clip"])
    ]
    shared, alone = (table.loc["baseline-clip"] for table in tables)
    assert shared.loc["raw", "status"] == "converged"
    pd.testing.assert_frame_equal(shared, alone, check_exact=True)
