"""Names that rest on the order of the poses are doubtful where an import found it stated nowhere: a sorted table imitates a drift or a slip."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from scalar.data.dataset import Dataset
from scalar.diagnosis.naming.unstated_order import limited_by_order, unstated_order
from scalar.diagnosis.settings import DEFAULTS
from scalar.effects import Effect
from scalar.effects.joint_backlash import JointBacklash
from scalar.effects.joint_scale import JointScale
from scalar.effects.sensor_slip import SensorSlip
from scalar.effects.thermal_drift import ThermalDrift
from tests.diagnosis.stand_ins import finding_of
from tests.random_scene import make_scene

LEAST = DEFAULTS.naming.least_confidence
BY_ORDER = [SensorSlip(8.0, None, False), ThermalDrift("order", 0.0, last=19.0), JointBacklash(2, by="moves")]
BY_OTHERS = [JointScale(2), ThermalDrift("temperature", 20.0)]


def recorded(**columns: np.ndarray) -> Dataset:
    """Return a tracker's dataset with some of the optional columns of poses.csv, imported from tables that state no order."""
    dataset = make_scene("vs060", "tracker", poses_per_plane=20).dataset
    bare = dataset.poses.drop(columns=["order", "time"], errors="ignore")
    return replace(
        dataset, poses=bare.assign(**columns), imported={"mapping": "m.yaml", "order": "not stated"}
    )


def rows(dataset: Dataset) -> np.ndarray:
    """Return 0, 1, ... for each pose."""
    return np.arange(float(dataset.n_poses))


def confidence(effect: Effect, dataset: Dataset) -> tuple[float, bool]:
    """Return the confidence in a finding of 0.98 after the rule, and whether its name is doubtful."""
    (finding,) = limited_by_order([finding_of(effect, 0.98)], dataset, LEAST)
    return finding.confidence, finding.doubtful


@pytest.mark.parametrize("effect", BY_ORDER, ids=lambda effect: effect.name)
def test_what_follows_an_assumed_order_has_no_sure_name(effect):
    """Where nothing states the order, a slip, a drift by the order and play by the moves are doubtful, and the report says why."""
    dataset = recorded()
    most, doubtful = confidence(effect, dataset)
    assert most < LEAST and doubtful
    (suspicion,) = unstated_order(dataset, [effect])
    assert "nothing stated this order" in suspicion.sentence and "rows_in_order: true" in suspicion.sentence


@pytest.mark.parametrize("effect", BY_OTHERS, ids=lambda effect: effect.title)
def test_what_follows_no_order_keeps_its_name(effect):
    """An effect of the angles, or one driven by a recorded temperature, does not depend on the order of the rows."""
    dataset = recorded()
    assert confidence(effect, dataset) == (0.98, False)
    assert not unstated_order(dataset, [effect])


@pytest.mark.parametrize("effect", BY_ORDER, ids=lambda effect: effect.name)
def test_rows_of_a_dataset_that_was_not_imported_are_in_order(effect):
    """By its format, a dataset without the columns has its rows in the order of acquisition."""
    dataset = replace(recorded(), imported={})
    assert confidence(effect, dataset) == (0.98, False)
    assert not unstated_order(dataset, [effect])


@pytest.mark.parametrize("column", ["order", "time"])
def test_a_recorded_order_keeps_all_names(column):
    """With a column order or time, the order is stated."""
    dataset = recorded(**{column: rows(recorded())})
    assert all(confidence(effect, dataset) == (0.98, False) for effect in BY_ORDER)
    assert not unstated_order(dataset, BY_ORDER)


def test_recorded_directions_tell_play_without_the_order():
    """Play needs the direction from which a joint came; where that is recorded, the order of the rows does not matter."""
    dataset = recorded(approach2=np.where(rows(recorded()) % 2, 1.0, -1.0))
    assert confidence(JointBacklash(2, by="moves"), dataset) == (0.98, False)
