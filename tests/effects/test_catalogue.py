"""Effects in files and on the command line."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner

from scalar.cli import cli
from scalar.effects.command_line import named_effects, parse_effects
from scalar.effects.registry import known
from scalar.effects.restarted_warm_up import RestartedWarmUp
from scalar.effects.saving import effect_from_mapping, effect_to_mapping
from scalar.effects.title_reader import with_names
from scalar.errors import InvalidInput
from scalar.estimation.result import Calibration, load_calibration
from tests.effects.everything import every_effect, optional_columns
from tests.effects.injected import make_cell


@pytest.fixture(scope="module")
def cell():
    return make_cell(seed=5, poses_per_plane=8, points_per_scan=6, columns=optional_columns)


@pytest.fixture(scope="module")
def effects(cell):
    return every_effect(cell.dataset, np.random.default_rng(6))


def test_one_of_every_name_is_tested(effects):
    """The objects on which these tests run include one of every effect of the catalogue."""
    assert {effect.name for effect in effects} == set(known())


def test_what_every_effect_says_of_itself(effects):
    """Names, units and prior standard deviations are as many as coefficients, names are unique and end in a unit, and sentences have no full stop."""
    for effect in effects:
        k = len(effect.coefficients)
        assert k == len(effect.coefficient_names) == len(effect.coefficient_units)
        assert len(effect.prior_std) == k == len(set(effect.coefficient_names))
        assert np.all(effect.prior_std > 0)
        assert effect.sentence and not effect.sentence.endswith(".")
        assert all("_" in name for name in effect.coefficient_names)
        json.dumps(effect.target)


def test_mappings_come_back_through_json(effects):
    """An effect that is written as JSON text reads back the same, to the last bit."""
    for effect in effects:
        back = effect_from_mapping(
            json.loads(json.dumps(effect_to_mapping(effect, [None] * len(effect.coefficients))))
        )
        assert type(back) is type(effect)
        assert back.to_mapping() == effect.to_mapping()
        assert back.target == effect.target and back.key == effect.key
        np.testing.assert_array_equal(back.coefficients, effect.coefficients)


def test_calibrations_with_every_effect_predict_the_same_after_saving(cell, effects, tmp_path):
    """calibration.json holds whatever the prediction needs, for every effect alone and for all together."""
    dataset = cell.dataset
    nominal = Calibration.nominal(dataset)
    for chosen in [*((e,) for e in effects), tuple(effects)]:
        before = replace(nominal, model=replace(nominal.model, effects=tuple(chosen)))
        before.save(tmp_path / "calibration.json")
        after = load_calibration(tmp_path / "calibration.json")
        table = dataset.poses.assign(order=np.arange(dataset.n_poses))
        np.testing.assert_allclose(after.predict(table), before.predict(table), rtol=0, atol=1e-13)
        at_end = dataset.poses.drop(columns=["order"], errors="ignore")
        if all(getattr(e, "by", "") != "order" or getattr(e, "last", 0.0) is not None for e in chosen):
            np.testing.assert_allclose(after.predict(at_end), before.predict(at_end), rtol=0, atol=1e-13)
            assert np.isfinite(after.predict(at_end)).all()


def test_predictions_without_an_order_are_for_the_end(cell):
    """A growth by order, freed by its name, predicts without an order what it predicts at the last pose, and never NaN."""
    dataset = cell.dataset
    (growth,) = parse_effects("thermal_drift:order", dataset)
    nominal = Calibration.nominal(dataset)
    model = replace(nominal.model, effects=(growth.with_coefficients([1e-5]),))
    here = dataset.poses.drop(columns=["order"], errors="ignore")
    end, last = (
        replace(nominal, model=model).predict(t) for t in (here, here.assign(order=dataset.n_poses - 1.0))
    )
    np.testing.assert_array_equal(end, last)
    assert np.abs(end - nominal.predict(here)).max() > 1e-5


@pytest.mark.parametrize(
    ("effects", "column"),
    [("thermal_drift:temperature", "temperature"), ("joint_backlash:3", "approach3")],
)
def test_a_column_that_an_effect_needs_is_named(cell, effects, column):
    """Predicting without a column that an effect needs is refused, and the message names it."""
    nominal = Calibration.nominal(cell.dataset)
    chosen = parse_effects(effects, cell.dataset)
    calibration = replace(nominal, model=replace(nominal.model, effects=chosen))
    with pytest.raises(InvalidInput, match=column):
        calibration.predict(cell.dataset.poses.drop(columns=[column]))


GOOD = {
    "joint_compliance": 1,
    "joint_compliance:2": 1,
    "joint_harmonic:4:2": 1,
    "joint_harmonic:4:1:2:9": 1,
    "joint_harmonic": 6,
    "joint_ripple:3:40:48": 1,
    "joint_scale": 6,
    "joint_coupling:6:5": 1,
    "joint_compliance:2:3": 1,
    "joint_backlash:2": 1,
    "pose_lag": 6,
    "axis_nonparallel": 1,
    "axis_nonparallel:4": 1,
    "base_compliance": 1,
    "thermal_drift": 1,
    "sensor_slip:9": 1,
    "target_drift": 1,
    "target_drift:order": 1,
    "target_drift:12": 1,
    "range_scale,range_offset, range_distortion": 3,
    "plane_bow": 3,
    "plane_bow:wall_x": 1,
    "plane_moved:floor:12": 1,
    "": 0,
}


@pytest.mark.parametrize(
    "text",
    [
        "joint_compliance:2:3,joint_harmonic:4:1:2,joint_coupling:6:5",
        "joint_compliance:2,joint_backlash:3,joint_scale:1,joint_scale:5,base_compliance",
        "axis_nonparallel:3,joint_ripple:3:40:48,plane_bow:wall_x,range_scale,sensor_slip:12,plane_moved:floor:12",
        "thermal_drift:time",
        "target_drift:time",
        "target_drift:12",
    ],
)
def test_effects_are_named_as_they_are_read(cell, text):
    """The words that name effects to a person name the same ones on the command line, and what two calibrations have in common is listed once."""
    effects = parse_effects(text, cell.dataset)
    assert named_effects((*effects, *effects)) == text


def test_titles_mean_what_names_mean(cell, effects):
    """Whoever copies the title of an effect from report or terminal, with or without its quotes and its capital, frees that effect."""
    named = [e for e in effects if not e.flexible and not isinstance(e, RestartedWarmUp)]
    for restarted in (e for e in effects if isinstance(e, RestartedWarmUp)):  # of which this record has none
        assert with_names(f"{restarted.title}, joint_scale:2", known()) == "restarted_warm_up, joint_scale:2"
    for effect in named:
        wanted = [found.key for found in parse_effects(named_effects([effect]), cell.dataset)]
        title = effect.title
        for text in (
            title,
            f"“{title}”",
            title[0].upper() + title[1:],
            f"joint_scale:1, {title},plane_bow:wall_y",
        ):
            found = [found.key for found in parse_effects(text, cell.dataset)]
            several = text.startswith("joint_scale:1")
            assert (found[1:-1] if several else found) == wanted, text
    kinds = {
        effect.kind: effect.name for effect in named if effect.kind not in ("movement", "coupling", "ripple")
    }
    for kind, name in kinds.items():
        if name != "sensor_slip":
            assert parse_effects(kind, cell.dataset)[0].name == name


def test_the_help_lists_all_names_that_can_be_freed():
    """Whoever asks `scalar calibrate --help` finds every name that --effects takes."""
    said = CliRunner().invoke(cli, ["calibrate", "--help"]).output
    listed = set(re.findall(r"[a-z]+(?:_[a-z]+)+", said))
    assert {name for name, kind in known().items() if not kind.flexible} <= listed


@pytest.mark.parametrize("text", GOOD)
def test_effects_by_name(cell, text):
    """The command line takes a name with or without its target, and several names separated by commas."""
    assert len(parse_effects(text, cell.dataset)) == GOOD[text]


BAD = {
    "joint_skale": "did you mean joint_scale",
    "pose_jitter": "no effect 'pose_jitter' that can be freed",
    "unattributed": "no effect 'unattributed' that can be freed",
    "timing_belt:5": "one of your own needs --effects-module",
    "joint_scale:7": "joints 1 to 6",
    "joint_scale:0": "joints 1 to 6",
    "joint_scale:-1": "joints 1 to 6",
    "joint_scale:two": "joints 1 to 6",
    "joint_scale:1:2": "too many words",
    "joint_scale:2,joint_scale:2": "named twice",
    "joint_harmonic:4:0": "orders 1 to 32",
    "joint_harmonic:4:33": "orders 1 to 32",
    "joint_harmonic:4:x": "orders 1 to 32",
    "joint_ripple:4": "joint_ripple:3:40:48",
    "joint_ripple:4:32": "orders 33 to 64",
    "joint_coupling": "joint_coupling:6:5",
    "joint_coupling:6": "joint_coupling:6:5",
    "joint_coupling:3:3": "joint_scale:3",
    "sensor_slip": "sensor_slip:120",
    "sensor_slip:soon": "order of acquisition",
    "sensor_slip:nan": "order of acquisition",
    "plane_moved:floor": "plane_moved:floor:120",
    "plane_moved:roof:3": "no plane 'roof'; there are floor",
    "plane_bow:roof": "no plane 'roof'; there are floor",
    "thermal_drift:humidity": "temperature, time, order",
}


@pytest.mark.parametrize("text", BAD)
def test_effects_that_mean_nothing_are_refused(cell, text):
    """Every refusal names the option and says what is available instead."""
    with pytest.raises(InvalidInput) as caught:
        parse_effects(text, cell.dataset)
    assert caught.value.exit_status == 2
    assert "--effects" in str(caught.value) and BAD[text] in str(caught.value)


def test_every_fault_of_a_list_is_named(cell):
    """A list of effects with several faults gives one line for each."""
    with pytest.raises(InvalidInput) as caught:
        parse_effects("joint_skale,joint_scale:9,plane_bow", cell.dataset)
    assert len(caught.value.faults) == 2


def test_a_drift_without_its_column_is_refused():
    """A drift with the temperature is refused if the temperature was not recorded."""
    plain = make_cell(seed=5, poses_per_plane=4, points_per_scan=6).dataset
    with pytest.raises(InvalidInput, match="no column 'temperature'"):
        parse_effects("thermal_drift:temperature", plain)
    with pytest.raises(InvalidInput, match="no column 'time'"):
        parse_effects("restarted_warm_up:time", plain)
    with pytest.raises(InvalidInput, match="time, order"):
        parse_effects("restarted_warm_up:temperature", plain)
    (by_order,) = parse_effects("thermal_drift", plain)
    assert by_order.to_mapping()["by"] == "order"
