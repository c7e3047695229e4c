"""A reflector that was exchanged or put elsewhere on the flange during the campaign, without another name in the column ``target`` of its table.

From some pose on, the target sits at another place of the flange. No place of the tracker explains that, because the shift turns with the flange.
If targets seem to have changed places, it is their names in the table that are exchanged from that pose on (``exchanged_names``).
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from scalar.data.dataset import Dataset
from scalar.estimation.setup.alternatives import Alternative
from scalar.estimation.setup.sensor.exchanged_names import with_names_as_meant
from scalar.estimation.setup.sessions.first_pose_after import best_break
from scalar.estimation.setup.trial import full_fit, nominal_fit
from scalar.sensors import Target, kind_of, measure, on_flange
from scalar.units import MM

LEAST_POSES = 10  # with each target: with fewer, another place of the target may explain gross errors
LATER = ", from there on"  # ends the name of a target after the change
# Largest residual of the set-up as described: a reflector that is put elsewhere on a flange is moved by less, and leaves less.
FARTHEST = 300 * MM
IN_ITS_PLACE = 0.1  # of the least distance between targets: if each sits so near to where another one sat, their names are exchanged


def exchanged_targets(dataset: Dataset) -> Iterator[Alternative]:
    """Yield the alternative in which the targets on the flange are others from a pose on, or have exchanged names from it on.

    The pose is the one that leaves the smallest residual.
    """
    if on_flange(measure(dataset).initial_target(dataset)) is None or nominal_fit(dataset).rms > FARTHEST:
        return
    k = best_break(dataset, _with_break, LEAST_POSES)
    if k is None:
        return
    changed = _with_break(dataset, k)
    trial = full_fit(changed)
    if trial is None or not np.isfinite(shift := _largest_shift(trial.model.target)):
        return
    meant = _changed_places(trial.model.target)
    yield _other_names(dataset, k, meant) if meant else _other_place(dataset, k, shift, changed)


def _other_names(dataset: Dataset, k: int, meant: Mapping[str, str]) -> Alternative:
    """Return the alternative in which names of targets are exchanged from row ``k`` on; ``meant`` has the right name for each that is written."""
    pose, table = dataset.pose_ids[k], kind_of(dataset).format.measured_in
    written = list(meant)
    if len(written) == 2:
        first, second = written
        says = f"from pose {pose} on the names '{first}' and '{second}' of the targets are exchanged"
    else:
        pairs = ", ".join(f"'{name}' stands for '{meant[name]}'" for name in written)
        says = f"from pose {pose} on the names of {len(written)} targets are exchanged: {pairs}"
    return Alternative(
        "exchanged_names",
        table,
        says,
        "with them as they are meant there",
        f"correct them in the column target of {table} from pose {pose} on; where 'scalar import' made it, look where the columns or rows of "
        "the targets change places in the files that it read",
        with_names_as_meant(dataset, np.arange(dataset.n_poses) >= k, meant),
    )


def _other_place(dataset: Dataset, k: int, shift: float, changed: Dataset) -> Alternative:
    """Return the alternative in which the target sits elsewhere from row ``k`` on, by ``shift`` [m]; ``changed`` has other names from there on."""
    pose, table = dataset.pose_ids[k], kind_of(dataset).format.measured_in
    return Alternative(
        "exchanged_target",
        f"pose {pose}",
        f"from pose {pose} on the target sits elsewhere on the flange, {shift / MM:.3g} mm from where it sat before",
        "with a target of its own from there on",
        f"write a column target into {table} with another name from pose {pose} on (another reflector, or the same at another place), or calibrate "
        "the two parts one by one",
        changed,
        file=table,
    )


def _largest_shift(target: Target) -> float:
    """Return how far the targets sit from where they sat before [m], the farthest of those that were measured before and after."""
    targets = on_flange(target)
    places = dict(zip(targets.names, targets.coordinates[:, :3], strict=True))
    pairs = [(place, places[name + LATER]) for name, place in places.items() if name + LATER in places]
    return max((float(np.linalg.norm(after - before)) for before, after in pairs), default=np.nan)


def _changed_places(target: Target) -> dict[str, str]:
    """Return, by the name that is written after the change, the target that sat there before; empty unless some changed places among themselves."""
    targets = on_flange(target)
    places = dict(zip(targets.names, targets.coordinates[:, :3], strict=True))
    before = [name for name in places if name and name + LATER in places]
    if len(before) < 2:
        return {}
    apart = min(float(np.linalg.norm(places[a] - places[b])) for a, b in itertools.combinations(before, 2))
    meant = {}
    for name in before:
        off = {other: float(np.linalg.norm(places[name + LATER] - places[other])) for other in before}
        nearest = min(off, key=lambda other: off[other])
        if off[nearest] < IN_ITS_PLACE * apart:
            meant[name] = nearest
    changed = {name: other for name, other in meant.items() if name != other}
    return changed if set(changed) == set(changed.values()) else {}


def _with_break(dataset: Dataset, k: int) -> Dataset:
    """Return the dataset whose targets have other names from row ``k`` on."""
    names = dataset.targets or ("before",)
    index = dataset.point_columns.get("target", np.zeros(len(dataset.points)))
    later = np.repeat(np.arange(dataset.n_poses) >= k, np.diff(dataset.starts))
    return replace(
        dataset,
        targets=(*names, *(name + LATER for name in names)),
        point_columns={**dataset.point_columns, "target": index + len(names) * later},
    )
