"""Thresholds: each is documented, none can be set by a wrong name, and the value that is set decides."""

from dataclasses import FrozenInstanceError, fields, is_dataclass, replace

import pytest

from scalar.diagnosis import diagnose
from scalar.diagnosis.fit.fitted_state import refit
from scalar.diagnosis.held_out.hold_out import held_out_errors
from scalar.diagnosis.settings import DEFAULTS, Settings
from scalar.estimation.geometry_fit import geometry_fit
from scalar.estimation.settings import changed, documentation
from tests.diagnosis.cases import scale

DOCUMENTED = documentation(DEFAULTS)


@pytest.fixture(scope="module")
def dataset():
    """Return a small dataset with a scale error of joint 4."""
    return scale(21, poses_per_plane=30)[0].dataset


@pytest.mark.parametrize("name", DOCUMENTED)
def test_every_threshold_is_documented(name):
    """Every threshold is a finite number with its unit, its meaning and its reason."""
    entry = DOCUMENTED[name]
    assert sorted(entry) == ["meaning", "reason", "unit", "value"]
    assert isinstance(entry["value"], (int, float)) and abs(entry["value"]) < float("inf")
    assert entry["unit"].strip() and len(entry["meaning"]) > 8 and len(entry["reason"]) > 4


def test_every_field_is_a_threshold_or_a_group_of_thresholds():
    """No field of the settings is undocumented: there are as many entries as numbers in all groups."""

    def leaves(settings):
        return sum(
            leaves(getattr(settings, f.name)) if is_dataclass(getattr(settings, f.name)) else 1
            for f in fields(settings)
        )

    assert leaves(DEFAULTS) == len(DOCUMENTED) > 60


@pytest.mark.parametrize("name", DOCUMENTED)
def test_one_threshold_is_changed_and_no_other(name):
    """A change by name gives new settings that differ in that threshold alone; the old ones stay as they were."""
    other = type(DOCUMENTED[name]["value"])(2 * DOCUMENTED[name]["value"])
    found = documentation(changed(DEFAULTS, {name: other}))
    assert found[name] == {**DOCUMENTED[name], "value": other}
    assert {k: v for k, v in found.items() if k != name} == {k: v for k, v in DOCUMENTED.items() if k != name}
    assert documentation(DEFAULTS) == DOCUMENTED


def test_settings_cannot_be_altered():
    """The settings are frozen, so that no run changes the thresholds of another."""
    with pytest.raises(FrozenInstanceError):
        DEFAULTS.selection.max_effects = 1  # type: ignore[misc]


@pytest.mark.parametrize(
    "name", ["selection", "selection.swap_margins", "swap_margin", "", "hold_out.folds.x"]
)
def test_a_name_that_is_no_threshold_is_refused(name):
    """A misspelt name, a group, or a name below a threshold is refused, and the message contains it."""
    with pytest.raises(ValueError, match=f"'{name}' is no threshold"):
        changed(DEFAULTS, {name: 1})


def test_an_unknown_field_is_refused():
    """The settings and their groups accept no other field."""
    with pytest.raises(TypeError, match="swap_margins"):
        replace(DEFAULTS.selection, swap_margins=1.0)  # type: ignore[call-arg]
    with pytest.raises(TypeError, match="hunt"):
        Settings(hunt=None)  # type: ignore[call-arg]


def test_a_threshold_of_the_selection_decides(dataset):
    """With settings that allow no effects none is found; by default the injected one is."""
    assert [f.effect.name for f in diagnose(dataset).findings] == ["joint_scale"]
    none = changed(
        DEFAULTS,
        {"selection.max_effects": 0, "subset_search.most_poses": 0, "flexible_terms.max_terms": 0},
    )
    assert not diagnose(dataset, settings=none).findings


@pytest.mark.slow
def test_a_threshold_of_the_estimator_decides(dataset):
    """Thresholds of gross errors reach the cleaning: no point is off by five standard deviations, and some are by three."""
    strict = {
        "estimation.gross_errors.point_sigmas": 3.0,
        "estimation.gross_errors.least_point_error": 0.0,
    }
    usual, fewer = diagnose(dataset), diagnose(dataset, settings=changed(DEFAULTS, strict))
    assert usual.cleaned.points == 0 < fewer.cleaned.points


def test_a_state_carries_its_settings(dataset):
    """A refitted state has the settings of the state from which it was made: with two folds, its held-out errors have the blocks of two folds."""
    model, prepared = geometry_fit(dataset)
    state = refit(dataset, model, prepared.free, (), changed(DEFAULTS, {"hold_out.folds": 2}))
    again = state.refitted(())
    blocks_per_fold = DEFAULTS.hold_out.blocks_per_fold
    assert again.settings.hold_out.folds == 2
    assert held_out_errors(again).block.max() + 1 == 2 * blocks_per_fold
