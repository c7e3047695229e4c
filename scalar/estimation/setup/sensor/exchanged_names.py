"""Two targets on one flange whose names are exchanged in some rows: the tracker measured one of them and wrote the name of the other.

Seen from the flange, each of the two then sits where the other one sits. That distinguishes the error from a reflector that was put elsewhere, and
from a pose whose joint angles are wrong.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from scalar.data.dataset import Dataset
from scalar.estimation.model import Model
from scalar.estimation.pose_consistency import distances_under
from scalar.geometry.se3 import Array
from scalar.sensors import kind_of
from scalar.units import MM

# With the names exchanged, a pose has to lie nearer than this share of its distance as written to where a fit to the others has it.
FALLS_TO = 0.1
# It also has to lie within the larger of these: no effect of an arm makes a pose err farther.
LEAST_NEAR = 3 * MM
TIMES_USUAL = 10.0  # times the median distance of the other poses
MOST_ALONE = 3  # poses that have a sentence each; more have one together
MOST_IDS = 30  # poses that such a sentence names


def with_names_as_meant(dataset: Dataset, rows: Array, meant: Mapping[str, str]) -> Dataset:
    """Return the dataset with other names of targets in some poses.

    Args:
        dataset: With several targets.
        rows: ``(N,)`` bool, the poses whose names are wrong.
        meant: The right name for each that is wrong there.
    """
    right = np.arange(len(dataset.targets))
    for written, name in meant.items():
        right[dataset.targets.index(written)] = dataset.targets.index(name)
    index = dataset.point_columns["target"].astype(int)
    there = np.repeat(rows, np.diff(dataset.starts))
    columns = {**dataset.point_columns, "target": np.where(there, right[index], index)}
    return replace(dataset, point_columns=columns)


def with_names_exchanged(dataset: Dataset, rows: Array, first: str, second: str) -> Dataset:
    """Return the dataset with the names of two targets exchanged in some poses.

    Args:
        dataset: With several targets.
        rows: ``(N,)`` bool, the poses in which they are exchanged.
        first: Name of one target.
        second: Name of the other.
    """
    return with_names_as_meant(dataset, rows, {first: second, second: first})


def names_exchanged_in_words(
    dataset: Dataset, model: Model, rows: Array, distances: Array
) -> tuple[Array, list[str]]:
    """Return which poses exchanged names explain, ``(N,)`` bool, and sentences that say so: one for each of a few poses, or one for many.

    Args:
        dataset: What was measured.
        model: As fitted to the other poses.
        rows: ``(N,)`` bool, the poses that contradict the others.
        distances: ``(N,)`` [m], how far every pose lies from where the model has it.
    """
    explained, sentences = np.zeros(dataset.n_poses, dtype=bool), []
    if len(dataset.targets) < 2 or "target" not in dataset.point_columns or not rows.any():
        return explained, sentences
    near = max(LEAST_NEAR, TIMES_USUAL * float(np.median(distances[~rows])))
    pairs = list(itertools.combinations(dataset.targets, 2))
    then = np.array([distances_under(with_names_exchanged(dataset, rows, *pair), model) for pair in pairs])
    best = then.argmin(axis=0)
    for k, pair in enumerate(pairs):
        these = rows & (best == k) & (then[k] < np.minimum(near, FALLS_TO * distances))
        explained |= these
        found = np.flatnonzero(these)
        groups = [found[i : i + 1] for i in range(len(found))] if len(found) <= MOST_ALONE else [found]
        for group in groups:
            sentences.append(_in_words(dataset, pair, group, then[k], distances))
    return explained, sentences


def _in_words(dataset: Dataset, pair: tuple[str, str], rows: Array, then: Array, distances: Array) -> str:
    """Return the sentence on poses, ``rows``, in which the names of a pair are exchanged; distances ``(N,)`` [m] with them exchanged and without."""
    ids = [str(pose) for pose in dataset.pose_ids[rows]]
    one = len(ids) == 1
    more = f" and {len(ids) - MOST_IDS} more" if len(ids) > MOST_IDS else ""
    where = f"pose {ids[0]}" if one else f"{len(ids)} poses ({', '.join(ids[:MOST_IDS])}{more})"
    they_lie, of_this, at_most, at_least = (
        ("it lies", "of this pose", "", "") if one else ("they lie", "of these poses", "at most ", " or more")
    )
    return (
        f"in {where} the names '{pair[0]}' and '{pair[1]}' of the targets are exchanged: with the two exchanged {they_lie} "
        f"{at_most}{then[rows].max() / MM:.2g} mm from where a fit to the others has {'it' if one else 'them'}, and as written "
        f"{distances[rows].min() / MM:.3g} mm{at_least}; exchange them in the rows {of_this} in {kind_of(dataset).format.measured_in}"
    )
