"""Test whether further poses, planned by `scalar plan --after`, separate the causes that a diagnosis could not distinguish.

The sets are those of the blind trials with one effect that acts by the joint angles, at the same sizes and from the same seeds, but with fewer poses,
so that more causes are confounded. Each set is diagnosed. If causes are confounded, further poses are chosen from a pool of postures in which
the scanner sees a target plane; as a control, as many are drawn from the pool at random. Both choices are then measured in the same simulated scene,
and the diagnosis is made anew, which shows whether the causes are separated as expected. The table has a row for each pair of confounded causes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from scalar.data.dataset import Dataset
from scalar.data.io.atomic import plain
from scalar.diagnosis import diagnose
from scalar.effects import Effect
from scalar.errors import ScalarError
from scalar.geometry.se3 import Array
from scalar.planning.questions import Pair, open_pairs, with_doubtful
from scalar.planning.workcell import View
from study.blind_trials.cases import Set, Study
from study.blind_trials.score import Entry, same
from study.common.in_memory import dataset_in_memory
from study.common.scene_config import scene_config
from study.planning.further_poses import FurtherPoses

PLANNED, RANDOM = "planned", "random"
SEPARATION_COLUMNS = {
    "case": "case of the blind trials",
    "workcell": "robot, scanner and target planes",
    "seed": "seed of all random draws in the scene",
    "size": "size of the injected effect, as a multiple of its natural size",
    "pairs": "number of pairs of confounded causes in the set; with none, the rest of the row is empty",
    "effect": "the effect that was found",
    "rival": "another effect that would explain the same residual as well",
    "right": "effect, rival or neither: which was injected",
    "now": "the signal that distinguishes the two, in standard errors, with the poses that were diagnosed",
    "planned": "the same signal with the planned poses as well",
    "random": "the same with as many random poses instead",
    "best": "a bound of the same signal that no choice of as many poses of the pool exceeds",
    "limit": "the same signal with all poses of the pool",
    "separable": "whether some choice of as many poses may separate the two: the bound is five standard errors or more",
    "separable_by_all": "whether the whole pool is expected to separate them",
    "separated": "whether the planned poses are expected to separate them",
    "separated_at_random": "whether the random poses are expected to separate them",
    "distinguished": "whether the diagnosis with the planned poses finds something and no longer confounds the two",
    "distinguished_at_random": "the same with the random ones",
    "right_then": "whether the injected effect is named with the planned poses, with nothing listed as confounded with it",
    "right_then_at_random": "the same with the random ones",
}


@dataclass(frozen=True)
class Sizes:
    """Numbers of poses.

    Attributes:
        first: Number of poses of each plane that are diagnosed first.
        pool: Number of postures of each plane from which further poses are chosen.
        further: Number of poses that are added, on all planes together.
    """

    first: int
    pool: int
    further: int


def separate_sets(
    study: Study, case: str, workcell: str, repetitions: str, root: Path, sizes: Sizes
) -> pd.DataFrame:
    """Return the pairs of confounded causes of a job of the blind trials, columns ``SEPARATION_COLUMNS``.

    Args:
        study: The blind trials.
        case: Case of the job.
        workcell: Workcell of the job.
        repetitions: First and last repetition of the job, ``001-010``.
        root: Folder from which the paths of scenes start.
        sizes: Numbers of poses.

    Raises:
        InvalidInput: The scene is at fault.
        SimulationError: Too few postures see a target plane.
    """
    # Imported here: the simulator needs pybullet, an optional dependency.
    from scalar.simulation.plan import PosePlan, plan_poses

    scene = root / study.workcells[workcell]["scene"]
    overrides = (
        study.scene,
        study.workcells[workcell]["overrides"],
        {"poses_per_plane": sizes.first + sizes.pool, "truth_poses": 1},
    )
    rows: list[dict[str, Any]] = []
    plans: dict[int, PosePlan] = {}
    for wanted in study.sets(case, workcell, repetitions):
        config = scene_config(scene, overrides, seed=wanted.seed, name=workcell)
        plan = plans.get(wanted.seed)
        if plan is None:
            plan = plans[wanted.seed] = plan_poses(config, base_dir=scene.parent)
        found = _pairs_of_set(wanted, config, scene.parent, plan, sizes)
        rows += found
        print(
            f"{case} {workcell} seed {wanted.seed} size {wanted.size:g}: {found[0]['pairs']} pairs",
            flush=True,
        )
    return pd.DataFrame(rows).reindex(columns=list(SEPARATION_COLUMNS))


def _pairs_of_set(
    wanted: Set, config: Mapping[str, Any], base_dir: Path, plan: Any, sizes: Sizes
) -> list[dict[str, Any]]:
    """Return the rows of one set; one row without a pair if nothing is confounded or the set cannot be simulated or diagnosed."""
    from scalar.simulation.errors import SimulationError
    from scalar.simulation.scene import simulate

    key = {
        "case": wanted.case,
        "workcell": wanted.workcell,
        "seed": wanted.seed,
        "size": wanted.size,
        "pairs": 0,
    }
    entries = {**config, **wanted.overrides, "injected": [dict(entry) for entry in wanted.injected]}
    try:
        simulated = simulate(entries, base_dir=base_dir, plan=plan)
        every = dataset_in_memory(simulated)
        first = first_of_each_plane(every.plane_index, sizes.first)
        diagnosis = diagnose(every.subset(first))
    except (ScalarError, SimulationError):
        return [key]
    pairs, _ = open_pairs(
        plain(diagnosis.to_mapping()), diagnosis.calibration_after.model.effects, diagnosis.dataset
    )
    confounded = sum(pair.rival is not None for pair in pairs)
    if not confounded:
        return [key]
    view = View(points=config["sensor"]["points_per_scan"])
    seed = [wanted.seed, sizes.further]
    further = FurtherPoses.of(every, first, diagnosis, pairs, view, sizes.further, seed)
    again = {
        way: _effects_of(every.subset(np.concatenate([first, poses])))
        for way, poses in ((PLANNED, further.planned), (RANDOM, further.random))
    }
    injected = simulated.truth["effects"][0]
    return [
        key | {"pairs": confounded} | signals | _after_further_poses(pair, injected, again)
        for pair, signals in further.signals
    ]


def _after_further_poses(
    pair: Pair, injected: Entry, again: Mapping[str, Sequence[Entry] | None]
) -> dict[str, Any]:
    """Return the cells of a row on the two causes and on what the diagnoses with the further poses say of them.

    Args:
        pair: The two causes.
        injected: What was injected.
        again: ``{PLANNED or RANDOM: the effects that are found with these poses, or None}``.
    """
    assert pair.rival is not None
    return {
        "effect": pair.effect.title,
        "rival": pair.rival.title,
        "right": _right(pair, injected),
        "distinguished": distinguished(pair, again[PLANNED]),
        "distinguished_at_random": distinguished(pair, again[RANDOM]),
        "right_then": named_alone(injected, again[PLANNED]),
        "right_then_at_random": named_alone(injected, again[RANDOM]),
    }


def first_of_each_plane(plane: Array, count: int) -> Array:
    """Return the indices of the first ``count`` poses of each plane, ascending; ``plane`` ``(N,)`` is the index of each pose's plane."""
    return np.sort(np.concatenate([np.flatnonzero(plane == k)[:count] for k in np.unique(plane)]))


def distinguished(pair: Pair, effects: Sequence[Entry] | None) -> bool:
    """Return whether a diagnosis finds something, and no longer names one of a pair with the other listed as confounded with it.

    If neither of the two was injected, a diagnosis that names neither is also counted.

    Args:
        pair: A pair with a rival.
        effects: Entries of ``diagnosis.json``; None if the diagnosis failed.
    """
    assert pair.rival is not None

    def confounds(entry: Entry, one: Effect, other: Effect) -> bool:
        return _is(one, entry) and any(_is(other, listed) for listed in entry["confounded_with"])

    both = (pair.effect, pair.rival), (pair.rival, pair.effect)
    return bool(effects) and not any(
        confounds(entry, *way) for entry in with_doubtful(effects) for way in both
    )


def named_alone(injected: Entry, effects: Sequence[Entry] | None) -> bool:
    """Return whether a diagnosis names what was injected, at its place, and lists nothing else in its place."""
    return any(same(entry, injected) and not entry["confounded_with"] for entry in effects or ())


def _effects_of(dataset: Dataset) -> Sequence[Entry] | None:
    """Return the effects that a diagnosis finds, as entries of ``diagnosis.json``; None if it fails."""
    try:
        return plain(diagnose(dataset).to_mapping())["effects"]
    except ScalarError:
        return None


def _right(pair: Pair, injected: Entry) -> str:
    """Return which of a pair was injected: ``effect``, ``rival`` or ``neither``."""
    for which, effect in (("effect", pair.effect), ("rival", pair.rival)):
        if effect is not None and same({"name": effect.name, "target": plain(effect.target)}, injected):
            return which
    return "neither"


def _is(effect: Effect, entry: Entry) -> bool:
    """Return whether an entry of ``diagnosis.json`` is an effect, by name and target."""
    return effect.name == entry["name"] and plain(effect.target) == entry["target"]
