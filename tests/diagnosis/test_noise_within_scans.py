"""Errors that are correlated along a scan, or a surface with waves, give no effect of the arm and hide none; ideal data are diagnosed as before."""

from dataclasses import replace
from importlib import import_module

import numpy as np
import pytest

from scalar.data.io.atomic import plain
from scalar.diagnosis import diagnose
from scalar.diagnosis.fit.fitted_state import refit
from scalar.diagnosis.fit.measured_rows import MeasuredRows, rows_given_own_noise
from scalar.estimation.geometry_fit import geometry_fit
from scalar.estimation.result import Calibration
from scalar.estimation.settings import DEFAULTS
from scalar.report.own_noise import own_noise
from tests.diagnosis import cases
from tests.effects.injected import Flaws, PoseData, make_cell, true_frames

SIGMA = 1e-4  # m
SMALL = {"poses_per_plane": 22, "points_per_scan": 60}


def scanned(cell, errors):
    """Return a workcell's dataset with errors of the points along their rays, ``errors(rng, angles)`` for each scan with its points in the order of
    the angles.
    """
    data = cell.dataset
    points = data.points.copy()
    rng = np.random.default_rng(len(points))
    for a, b in zip(data.starts[:-1], data.starts[1:], strict=True):
        cloud = points[a:b]
        order = np.argsort(np.arctan2(cloud[:, 0], cloud[:, 1]))
        e = np.empty(b - a)
        e[order] = errors(rng, np.arctan2(cloud[order, 0], cloud[order, 1]))
        points[a:b] = cloud * (1.0 + e / np.linalg.norm(cloud, axis=1))[:, None]
    return replace(data, points=points, sensor=replace(data.sensor, noise=SIGMA))


def autoregressive(rng, angles, rho=0.8):
    """Return errors with the correlation rho over the mean spacing of the points."""
    kept = rho ** (np.diff(angles) / np.mean(np.diff(angles)))
    e = rng.standard_normal(len(angles))
    for i, c in enumerate(kept, start=1):
        e[i] = c * e[i - 1] + np.sqrt(1.0 - c * c) * e[i]
    return SIGMA * e


def speckle(rng, angles):
    """Return the mean over eight points of a speckle pattern, skewed as its intensities are."""
    grains = np.cumsum(np.r_[0.0, rng.exponential(size=2200) - 1.0])
    at = np.interp(angles, [angles[0], angles[-1]], [0.0, 1800.0]).astype(int)
    window = 8 * 1800 // len(angles)
    return SIGMA * (grains[at + window] - grains[at]) / np.sqrt(window)


def wavy(cell):
    """Return a workcell's dataset on planes with waves of 0.04 mm, 50 mm long; its points err independently by 0.07 mm."""
    data = cell.dataset
    N = data.n_poses
    T = true_frames(
        cell.scene.truth, cell.flaws, PoseData(data.q, np.arange(float(N)), {}), np.zeros_like(data.q)
    )
    owner = np.repeat(np.arange(N), np.diff(data.starts))
    rays = data.points / np.linalg.norm(data.points, axis=1)[:, None]
    there = T[owner, :3, 0] * data.points[:, :1] + T[owner, :3, 2] * data.points[:, 1:] + T[owner, :3, 3]
    normal = cell.scene.truth.normals[data.plane_index][owner]
    slant = np.sum(normal * (T[owner, :3, 0] * rays[:, :1] + T[owner, :3, 2] * rays[:, 1:]), axis=1)
    rng = np.random.default_rng(N)
    waves = rng.standard_normal((3, 6, 3))
    waves *= 2 * np.pi / 0.05 / np.linalg.norm(waves, axis=2, keepdims=True)
    phase = np.einsum("pkx,px->pk", waves[data.plane_index][owner], there) + rng.uniform(0, 6.28, 6)
    height = 4e-5 * np.sqrt(2 / 6) * np.sin(phase).sum(1)
    e = -height / slant + 0.7 * SIGMA * rng.standard_normal(len(slant))
    return replace(data, points=data.points + e[:, None] * rays, sensor=replace(data.sensor, noise=SIGMA))


def quiet(case=None, seed=0, **settings):
    """Return a workcell with hardly any noise of its own."""
    settings = SMALL | {"noise": 1e-9} | settings
    return make_cell(Flaws(), seed=seed, **settings) if case is None else case(seed, **settings)[0]


def before(dataset, noise=True):
    """Return the state without effects, with or without the noise that is estimated from the points."""
    model, prepared = geometry_fit(dataset)
    rows = (
        rows_given_own_noise(dataset, model, DEFAULTS.within_scan_noise) if noise else MeasuredRows(dataset)
    )
    return refit(dataset, model, prepared.free, (), rows=rows)


@pytest.mark.parametrize("errors", [autoregressive, speckle], ids=["autoregressive", "speckle"])
def test_rows_of_correlated_scans_are_white_again(errors):
    """Over four workcells the rows' mean square is about one with the noise estimated from the points, and several times that without."""
    ratios = {True: [], False: []}
    for seed in range(4):
        dataset = scanned(quiet(seed=seed), errors)
        for noise, found in ratios.items():
            found.append(before(dataset, noise).background_within_scans().variance)
    assert 0.7 < np.mean(ratios[True]) < 1.4
    assert np.mean(ratios[False]) > 1.8 * np.mean(ratios[True])


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize("kind", ["autoregressive", "speckle", "waves"])
def test_a_scanner_alone_is_no_effect(kind, seed):
    """With correlated noise on an arm without errors, no effect, jitter or bias is named, but components of scanner or surface are."""
    cell = quiet(seed=seed)
    dataset = (
        wavy(cell)
        if kind == "waves"
        else scanned(cell, {"autoregressive": autoregressive, "speckle": speckle}[kind])
    )
    found = diagnose(dataset)
    mapping = found.to_mapping()
    assert mapping["verdict"] == "no_effect" and not mapping["effects"]
    names = [c["name"] for c in mapping["noise"]["components"]]
    assert names[0] == ("surface_waviness" if kind == "waves" else "scan_correlation")
    assert found.calibration_after.noise == tuple(mapping["noise"]["components"])
    assert found.calibration_after.model.vector == pytest.approx(found.calibration_before.model.vector)


@pytest.mark.slow
@pytest.mark.parametrize("case", [cases.scale, cases.coupling, cases.nonparallel])
@pytest.mark.parametrize("kind", ["autoregressive", "waves"])
def test_an_effect_is_named_in_spite_of_the_scanner(kind, case):
    """One effect of natural size under correlated noise is named with its place, and nothing else is."""
    _, name, target = case(3, **SMALL)
    cell = quiet(case, seed=3, poses_per_plane=34)
    dataset = wavy(cell) if kind == "waves" else scanned(cell, autoregressive)
    mapping = diagnose(dataset).to_mapping()
    assert len(mapping["effects"]) == 1 and cases.judged(mapping["effects"], name, target)


@pytest.mark.slow
def test_ideal_data_give_the_same_answer_to_the_last_byte(monkeypatch):
    """With white noise as stated, the files are the same whether or not the noise is estimated from the points."""
    dataset = cases.scale(5, **SMALL)[0].dataset
    asked = diagnose(dataset)
    module = import_module("scalar.diagnosis.explained")
    monkeypatch.setattr(
        module, "rows_given_own_noise", lambda dataset, model, settings: MeasuredRows(dataset)
    )
    unasked = diagnose(dataset)
    assert plain(asked.to_mapping()) == plain(unasked.to_mapping())
    assert plain(asked.calibration_after.to_mapping()) == plain(unasked.calibration_after.to_mapping())
    assert plain(asked.calibration_before.to_mapping()) == plain(unasked.calibration_before.to_mapping())
    assert own_noise(asked) is None


@pytest.mark.slow
def test_the_noise_is_kept_by_the_file_and_shown_in_the_report(tmp_path):
    """A calibration file keeps the noise components, and the report has their sentences and a picture."""
    found = diagnose(scanned(quiet(seed=4), autoregressive))
    found.calibration_after.save(tmp_path / "after.json")
    assert Calibration.load(tmp_path / "after.json").noise == tuple(found.calibration_after.noise)
    shown = own_noise(found)
    assert shown is not None and any("neighbouring points" in text for text in shown["sentences"])
    assert "<svg" in shown["picture"].before
