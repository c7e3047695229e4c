"""Diagnoses and a page that several modules of tests use; each is made once in a run."""

from __future__ import annotations

import pytest

from scalar.diagnosis import Diagnosis, diagnose
from scalar.report import render_report
from tests.random_scene import make_scene
from tests.report.periodic_joint import harmonic_dataset, hostile


@pytest.fixture(scope="session")
def periodic_diagnosis() -> Diagnosis:
    """Return the diagnosis of a workcell in which one joint errs periodically, with hostile names."""
    return diagnose(hostile(harmonic_dataset()))


@pytest.fixture(scope="session")
def null_diagnosis() -> Diagnosis:
    """Return the diagnosis of a workcell in which nothing was injected."""
    return diagnose(make_scene(seed=4, poses_per_plane=30, points_per_scan=20).dataset)


@pytest.fixture(scope="session")
def periodic_page(periodic_diagnosis: Diagnosis) -> str:
    """Return the report of ``periodic_diagnosis``."""
    return render_report(periodic_diagnosis)
