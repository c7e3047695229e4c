"""What was found is in view, and the advice says what to do about it, how to see it, and what changes in the controller."""

from __future__ import annotations

import re
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from scalar.data.poses import Poses
from scalar.diagnosis import Diagnosis, diagnose
from scalar.effects.axis_nonparallel import AxisNonparallel
from scalar.estimation.displacement import kinematics_at
from scalar.evaluate.workspace_errors import aligned_errors
from scalar.report import render_report, words
from scalar.report.advice import _columns, _in_controller
from tests.random_scene import make_scene
from tests.turning import turning


@pytest.fixture(scope="module")
def found() -> Diagnosis:
    """Return the diagnosis of a tracked arm one of whose joints errs periodically by a millimetre at the flange."""
    dataset = make_scene(kind="tracker", seed=1, poses_per_plane=25).dataset
    read = dataset.poses["q3"] - 2e-3 * np.sin(2 * dataset.poses["q3"] + 0.4)
    return diagnose(replace(dataset, poses=dataset.poses.assign(q3=read)))


@pytest.fixture(scope="module")
def page(found: Diagnosis) -> str:
    """Return its report."""
    return render_report(found)


@pytest.mark.slow
def test_what_was_found_stands_in_view_whatever_its_place_in_the_list(found: Diagnosis, page: str) -> None:
    """A finding is never folded away with the lesser candidates, whether it stands last among them or is not in the list."""
    title = words.capital(found.findings[0].effect.title)
    own = [entry for entry in found.ranking if words.capital(entry.effect.title) == title]
    others = [entry for entry in found.ranking if entry not in own]
    for diagnosis in (found, replace(found, ranking=(*others, *own))):
        in_view = candidates(render_report(diagnosis)).split("<details>")[0]
        assert f"<td>{title} <span" in in_view
    text = candidates(render_report(replace(found, ranking=tuple(others))))
    assert (
        f"Not in this list: “{found.findings[0].effect.title}”. It was found only with other effects" in text
    )


def candidates(page: str) -> str:
    """Return the section on the candidates."""
    return page.split("<h2>The candidates</h2>")[1].split("<h2>")[0]


def test_advice_is_what_to_do_how_to_see_it_and_what_changes_in_the_controller(
    found: Diagnosis, page: str
) -> None:
    """Each finding has one paragraph, headed by its title and the maker's name of the joint, and the controller has one."""
    section = page.split("<h2>What to do next</h2>")[1].split("<h2>")[0]
    items = re.findall(r"<li>(.*?)</li>", section)
    effect = found.findings[0].effect
    assert items[0].startswith(f"<strong>{words.capital(effect.title)} (J3).</strong>")
    assert effect.how_to_measure in items[0].replace("&#39;", "'")
    assert sum("In the controller." in item for item in items) == 1


def test_the_controller_gets_the_geometry_that_errs_less_without_effects(found: Diagnosis) -> None:
    """The file that is named is the one whose lengths and angles, effects left out, come nearer to after.json with its effects."""
    (item,) = _in_controller(found)
    named = re.search(
        r"give it those of (\w+).json: it then errs by (\S+) mm .* those of (\w+).json by (\S+) mm",
        item.sentences[0],
    )
    assert named is not None
    after = found.calibration_after.model
    poses = Poses.from_arrays(
        np.random.default_rng(4).uniform(*after.nominal.limits.T, (2000, 6)), {}, turning(6)
    )
    T = kinematics_at(after, poses).T_base_sensor
    models = {"before": found.calibration_before.model, "after": replace(after, effects=())}
    for file, stated in (named.group(1, 2), named.group(3, 4)):
        error = aligned_errors(kinematics_at(models[file], poses).T_base_sensor, T)
        assert 1e3 * np.linalg.norm(error, axis=1).mean() == pytest.approx(float(stated), rel=0.1)
    assert float(named[2]) <= float(named[4])


def test_geometry_that_holds_all_that_was_found_is_not_compared(found: Diagnosis) -> None:
    """Where a tilted axis alone was found, the geometry of after.json holds it: no error of rounding is stated, and nothing is said not to fit."""
    before = found.calibration_before
    tilt = AxisNonparallel(3, coefficients=np.array([1e-3]))
    tilted = SimpleNamespace(model=replace(before.model, effects=(tilt,)))
    after = SimpleNamespace(residuals=SimpleNamespace(poses=found.after.residuals.poses))
    diagnosis: Any = SimpleNamespace(
        verdict="effect", findings=(), calibration_before=before, calibration_after=tilted, after=after
    )
    (item,) = _in_controller(diagnosis)
    assert "after.json" in item.sentences[0] and "cannot hold" not in item.sentences[0]


def test_no_parameter_is_entered_while_structure_of_unknown_cause_is_left() -> None:
    """With an unattributed verdict the advice on the controller is to enter none of what was found, and it is the only one."""
    unknown: Any = SimpleNamespace(verdict="unattributed", findings=())
    (item,) = _in_controller(unknown)
    assert item.sentences[0].startswith("Enter none") and "export" not in " ".join(item.sentences)


@pytest.mark.parametrize("kind", ["line-laser", "probe"])
def test_a_noise_that_is_not_stated_is_asked_for_as_what_it_serves(kind: str) -> None:
    """Scans show their own noise, and the stated one is only compared with it; single contacts do not."""
    dataset = make_scene(kind=kind, seed=1, poses_per_plane=4).dataset
    unstated: Any = SimpleNamespace(dataset=replace(dataset, sensor=replace(dataset.sensor, noise=None)))
    (sentence,) = (text for text in _columns(unstated) if "noise in dataset.yaml" in text)
    assert ("compared with the noise that the scans themselves show" in sentence) == (kind == "line-laser")
