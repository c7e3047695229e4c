"""The tables of the worked example are made from the files that a diagnosis saves."""

import numpy as np
import pandas as pd
import pytest
from study.worked_example.tables import RANKED, diagnosis_tables

from scalar.data.dataset import read_dataset
from scalar.data.dataset_writer import write_dataset
from scalar.diagnosis import diagnose
from scalar.diagnosis.fit.scan_residuals import signed_residual
from scalar.diagnosis.selection import forward_selection
from scalar.report.output import write_diagnosis
from scalar.units import MM
from tests.diagnosis.cases import harmonic
from tests.diagnosis.gross_errors import spoiled


@pytest.fixture(scope="module")
def example(tmp_path_factory):
    """Return a folder with a dataset, three wrong poses among it, and its diagnosis; and that diagnosis as it was in memory."""
    folder = tmp_path_factory.mktemp("example")
    cell = harmonic(31, poses_per_plane=40)[0]
    data = spoiled(cell.dataset, np.random.default_rng(31), poses=0.025)[0]
    ids = np.repeat(data.pose_ids, np.diff(data.starts))
    scans = pd.DataFrame({"pose": ids, "x": data.points[:, 0], "z": data.points[:, 1]})
    write_dataset(folder / "dataset", mapping=cell.scene.mapping(), poses=data.poses, scans=scans)
    (folder / "diagnosis").mkdir()
    diagnosis = diagnose(read_dataset(folder / "dataset"))
    write_diagnosis(diagnosis, folder / "diagnosis")
    return folder, diagnosis


@pytest.fixture
def told(example, monkeypatch):
    """Return the tables, with every selection of effects forbidden."""

    def forbidden(*_):
        raise AssertionError("effects are selected once, by the diagnosis itself")

    for name in ("rank", "rivals", "select_forward"):
        monkeypatch.setattr(forward_selection, name, forbidden)
    folder, _ = example
    return diagnosis_tables(folder / "dataset", folder / "diagnosis")


def test_the_residuals_are_those_of_the_diagnosis(example, told):
    """Each pose that was not set aside has its residuals before and after to a nanometre, and no effect is selected again."""
    _, diagnosis = example
    poses = told["poses"]
    assert 0 < len(poses) < diagnosis.dataset.n_poses
    np.testing.assert_array_equal(poses["pose"], diagnosis.cleaned.dataset.pose_ids)
    for when, state in (("before", diagnosis.before), ("after", diagnosis.after)):
        np.testing.assert_allclose(poses[f"residual_{when}_mm"], signed_residual(state) / MM, atol=1e-6)
    np.testing.assert_allclose(
        poses["angle_deg"], np.rad2deg(diagnosis.cleaned.dataset.q)[:, joint(diagnosis) - 1]
    )


def joint(diagnosis):
    return diagnosis.findings[0].effect.target["joint"]


def test_the_candidates_are_those_of_the_diagnosis(example, told):
    """The table has the best candidates of the diagnosis in their order, each once, and only the one that was found is marked."""
    _, diagnosis = example
    ranking = told["ranking"]
    titles = list(dict.fromkeys(entry.effect.title for entry in diagnosis.ranking))
    assert list(ranking["candidate"]) == titles[:RANKED]
    assert ranking["evidence_nats"].is_monotonic_decreasing
    assert list(ranking["candidate"][ranking["found"]]) == [diagnosis.findings[0].effect.title]
    assert ranking["share_of_residual"].between(0, 1).all() and ranking["p_value"].between(0, 1).all()


def test_the_curve_is_the_effect_that_was_calibrated(example, told):
    """The curve's largest value is the amplitude of the calibrated coefficients, its standard error below a fifth of it."""
    _, diagnosis = example
    amplitude = np.rad2deg(np.hypot(*diagnosis.findings[0].effect.coefficients))
    assert np.abs(told["curve"]["effect_deg"]).max() == pytest.approx(amplitude, rel=0.02)
    assert 0 < told["curve"]["effect_std_deg"].max() < amplitude / 5
