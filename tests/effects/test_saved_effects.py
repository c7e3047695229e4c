"""What is saved of a calibration with effects is what was fitted: its predictions have the residuals of the fit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from scalar.data.dataset import Dataset
from scalar.effects import Effect
from scalar.effects.joint_scale import JointScale
from scalar.effects.parameter_names import parameter_names
from scalar.estimation.conclude import conclude
from scalar.estimation.joint_fit import unobservable_coefficients
from scalar.estimation.least_squares import fit
from scalar.estimation.prepare import Prepared, prepare
from scalar.estimation.residuals import Residuals
from scalar.estimation.result import load_calibration
from tests.effects.everything import every_effect, optional_columns, with_random_coefficients
from tests.effects.injected import make_cell


@dataclass(frozen=True)
class Prepared40:
    """A dataset, prepared for fits, with one of every effect."""

    dataset: Dataset
    prepared: Prepared
    effects: list[Effect]


@pytest.fixture(scope="module")
def case() -> Prepared40:
    cell = make_cell(seed=15, poses_per_plane=40, points_per_scan=6, columns=optional_columns)
    return Prepared40(
        cell.dataset, prepare(cell.dataset), every_effect(cell.dataset, np.random.default_rng(16))
    )


def sibling(effect: Effect, rng: np.random.Generator) -> Effect:
    """Return another effect of the same name at the same place: of another shape where it has one, else the same again."""
    own = effect.to_mapping()
    others = [v for v in effect.variations(1.0) if v.to_mapping() != own]
    return with_random_coefficients(others[-1] if others else effect, rng)


def check_saved(case: Prepared40, effects: Sequence[Effect], path: Path, *, free: bool) -> None:
    """Fit effects, or hold them as they are; what is loaded from the file predicts the residuals of the fit, wherever that ended."""
    model = replace(case.prepared.coarse, effects=tuple(effects))
    residuals = Residuals.of(case.dataset, model).reweighted(model)
    is_free = np.r_[case.prepared.free, np.full(sum(len(e.coefficients) for e in effects), free)]
    is_free &= ~unobservable_coefficients(residuals, model, is_free)
    found = fit(residuals, model, is_free)
    calibration = conclude(case.dataset, case.prepared, found, residuals)
    calibration.save(path)
    loaded = load_calibration(path)
    assert len(set(loaded.model.names)) == len(loaded.model.names)
    assert loaded.free == calibration.free
    np.testing.assert_array_equal(loaded.model.vector, calibration.model.vector)
    table = case.dataset.poses.assign(order=np.arange(case.dataset.n_poses, dtype=float))
    of_file = Residuals.of(case.dataset, loaded.model)
    squares, counts = of_file.measurement.distances(
        loaded.predict(table), loaded.model.target, of_file.point_effects(loaded.model)
    )
    fitted = residuals.pose_distances(found.model)
    np.testing.assert_allclose(np.sqrt(squares / counts), fitted, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("free", [True, False], ids=["estimated", "held"])
def test_two_of_one_name_at_one_place(case, free, tmp_path):
    """Two effects of one name at one place keep their own parameters in the file, for every effect."""
    rng = np.random.default_rng(17)
    for effect in case.effects:
        check_saved(case, [effect, sibling(effect, rng)], tmp_path / "calibration.json", free=free)


@settings(max_examples=25, deadline=None, derandomize=True)
@given(data=st.data())
def test_any_few_effects_together_keep_their_parameters(case, data, tmp_path_factory):
    """Any few effects together, some of them with one name and place, keep their own parameters in the file."""
    chosen = data.draw(st.lists(st.sampled_from(case.effects), min_size=1, max_size=4))
    rng = np.random.default_rng(data.draw(st.integers(0, 1000)))
    effects = [e if data.draw(st.booleans()) else sibling(e, rng) for e in chosen]
    check_saved(case, effects, tmp_path_factory.mktemp("saved") / "calibration.json", free=False)


def test_names_are_unique_whatever_keys_effects_have():
    """Every coefficient has a name of its own, even if keys repeat or look like repeated ones."""

    @dataclass(frozen=True, eq=False)
    class Named(JointScale):
        text: str = ""

        @property
        def key(self) -> str:
            return self.text

    texts = ["a", "a", "a#2", "b", "a", "a#2", "b#2", "b"]
    names = parameter_names([Named(1, text=t) for t in texts], taken=["b.scale_rad_per_rad"])
    assert len({name for own in names for name in own}) == len(texts)
