"""What a calibration is told of a scene: every injected effect at its place, and an effect for each flaw of scanner and target planes."""

from dataclasses import replace

import numpy as np
import pytest
from study.blind_trials.told import effects_in, significances, words_of

from scalar.effects.joint_scale import JointScale
from scalar.effects.saving import effect_to_mapping
from scalar.errors import InvalidInput
from scalar.estimation.calibrate import calibrate
from tests.effects.injected import make_cell

NOTHING = {"injected": [], "scanner": None, "surface": None}
PLACES = [
    ({"name": "joint_harmonic", "target": {"joint": 4, "order": 2}}, "joint_harmonic:4:2"),
    ({"name": "joint_harmonic", "target": {"joint": 4, "orders": [1, 3]}}, "joint_harmonic:4:1:3"),
    ({"name": "joint_compliance", "target": {"joints": [2, 3]}}, "joint_compliance:2:3"),
    ({"name": "joint_coupling", "target": {"source": 5, "joint": 6}}, "joint_coupling:6:5"),
    ({"name": "plane_moved", "target": {"at": {"order": 80.0, "time": None}, "plane": "floor"}}, "plane_moved:floor:80"),
    ({"name": "base_compliance", "target": {}}, "base_compliance"),
]  # fmt: skip


@pytest.fixture(scope="module")
def dataset():
    """Return a dataset of three target planes."""
    return make_cell(seed=44, poses_per_plane=10).dataset


@pytest.mark.parametrize(("entry", "words"), PLACES)
def test_an_injected_effect_is_freed_at_its_place(dataset, entry, words):
    """The words are those of the command line, whatever the order of the target's keys, and the effect that they free states the same target."""
    assert words_of(entry) == words
    if entry["name"] != "plane_moved":  # whose plane has another name in this dataset
        (effect,) = effects_in(NOTHING | {"injected": [entry]}, dataset)
        stated = effect_to_mapping(effect, [None] * len(effect.coefficients))
        assert stated["name"] == entry["name"] and effect.target == entry["target"] | effect.target


def test_flaws_are_told_once(dataset):
    """Bent surfaces free the bow of every plane, one that was injected included, and a distorting lens the map of the scanner."""
    first = dataset.planes[0].name
    truth = {
        "injected": [{"name": "plane_bow", "target": {"plane": first}}],
        "surface": {"bow_m": 2e-4},
        "scanner": {"linearity_m": 5e-5},
    }
    told = effects_in(truth, dataset)
    assert told is not None
    names = [effect.name for effect in told]
    assert names.count("plane_bow") == len(dataset.planes) and names.count("sensor_map") == 1
    assert len(names) == len(dataset.planes) + 1
    assert all(np.all(effect.coefficients == 0.0) for effect in told)


def test_a_cause_without_a_name_cannot_be_told(dataset):
    """There is no such calibration if one cause is no effect of the catalogue; a place that the dataset lacks is an error of the trial."""
    unknown = {"name": "unknown", "kind": "hose", "target": {}}
    assert effects_in(NOTHING | {"injected": [unknown]}, dataset) is None
    with pytest.raises(InvalidInput):
        effects_in(NOTHING | {"injected": [{"name": "joint_scale", "target": {"joint": 9}}]}, dataset)


@pytest.mark.parametrize("name", ["pose_jitter", "scan_bias"])
def test_a_random_error_is_left_out(dataset, name):
    """It has no coefficients; the other causes are told as without it."""
    scale = {"name": "joint_scale", "target": {"joint": 3}}
    told = effects_in(NOTHING | {"injected": [{"name": name, "target": {}}, scale]}, dataset)
    assert told is not None and [effect.name for effect in told] == ["joint_scale"]


def test_significance_counts_standard_errors_beyond_chance(dataset):
    """For one coefficient, the square of the number is that of the estimate over its standard error less one, and zero where that is less than
    chance; an effect that is there has far more than one that is not.
    """
    q, scale = dataset.q, 3e-3  # 3 mrad per rad: of real size
    there = replace(dataset, poses=dataset.poses.assign(q3=q[:, 2] / (1.0 + scale)))
    calibration = calibrate(there, effects=(JointScale(3), JointScale(5)))
    found = {entry["target"]["joint"]: z for entry, z in significances(calibration)}
    for effect, (std,) in zip(calibration.model.effects, calibration.effect_std, strict=True):
        ratio = float(effect.coefficients[0]) / std
        assert found[effect.target["joint"]] ** 2 == pytest.approx(max(ratio**2 - 1.0, 0.0), rel=1e-6)
    assert found[3] > 5.0 > found[5]
