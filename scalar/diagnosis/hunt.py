"""The hunt: score every candidate, add the best, refit everything, judge on held-out poses, repeat; then ask whether another would do as well.

A candidate is taken if its gain is beyond chance, corrected for all that were tried, and if it lowers the error on held-out poses. After every
step what is already in the model must still earn its place, and may be replaced by what explains the same better, so that the order in which
effects are found does not decide the answer.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import comb
from typing import TYPE_CHECKING

import numpy as np

from scalar.diagnosis.candidates import Candidate, candidates
from scalar.diagnosis.holdout import HeldOut, held_out, improvement
from scalar.diagnosis.score import Background, Projected, evidence, p_value, remainder, score_changes
from scalar.diagnosis.state import State, mixed, settle
from scalar.effects.base import BaseCompliance
from scalar.effects.catalogue import plane_centre
from scalar.effects.effect import Effect
from scalar.effects.joints import JointCompliance, JointHarmonic
from scalar.effects.sensor import SensorSlip
from scalar.effects.surface import PlaneMoved
from scalar.se3 import Array

if TYPE_CHECKING:
    from scalar.dataset import Dataset

ALPHA = 1e-3  # chance of taking an effect where there is none, corrected for all that were tried
LEAST_IMPROVEMENT = 2.0  # standard errors by which the held-out error has to fall
SWAP_MARGIN = 3.0  # nats of evidence by which another effect has to explain better to take a place
CONFOUNDED_MARGIN = 5.0  # nats within which the data do not tell two effects apart
MAX_EFFECTS = 60  # steps; harmonics of several joints take many
CHANGE_MARGIN = 6  # least number of poses on each side of a change
ROUNDING = 1e-4  # of the noise's variance: a residual below it is rounding, and its structure the computer's
_ALWAYS = -np.inf
_LEAST_P_VALUE = 1e-300  # below it the distribution's tail is no longer computed


@dataclass(frozen=True)
class Scored:
    """A candidate with its score.

    Attributes:
        effect: With the terms that are worth taking.
        gain: Drop of the squared whitened residual.
        dof: Directions seen.
        evidence: In nats.
        p_value: Corrected for all that were tried.
        observability: ``|E'| / |E|``.
    """

    effect: Effect
    gain: float
    dof: int
    evidence: float
    p_value: float
    observability: float


@dataclass(frozen=True, eq=False)
class Columns:
    """The whitened columns of everything that may be tried, at one model.

    Attributes:
        tried: Candidates with their columns.
        E: ``(N m, e)``, all columns.
        changes: (effect that acts always, its columns, the poses it touches) for every kind of change.
    """

    tried: list[tuple[Candidate, slice]]
    E: Array
    changes: list[tuple[Effect, slice, Array]]

    @cached_property
    def gram(self) -> Array:
        """Return ``E^T E``."""
        return self.E.T @ self.E

    @cached_property
    def sizes(self) -> Array:
        """Return the plausible size of every coefficient."""
        effects = [candidate.effect for candidate, _ in self.tried] + [
            effect for effect, _, _ in self.changes
        ]
        return np.concatenate([effect.plausible_sizes for effect in effects])

    @cached_property
    def by_width(self) -> dict[int, list[tuple[Candidate, slice]]]:
        """Return the candidates by their number of columns."""
        result: dict[int, list[tuple[Candidate, slice]]] = {}
        for candidate, where in self.tried:
            result.setdefault(where.stop - where.start, []).append((candidate, where))
        return result

    @property
    def total(self) -> int:
        """Return how many candidates and moments are tried."""
        return len(self.tried) + sum(int(touched.sum()) for _, _, touched in self.changes)


def columns(state: State, pool: Sequence[Candidate]) -> Columns:
    """Return the columns of a pool of candidates and of every kind of change at a state's model."""
    always = _changes(state.dataset)
    effects = [candidate.effect for candidate in pool] + [effect for effect, _ in always]
    E = state.columns_of(effects)
    ends = np.cumsum([len(effect.coefficients) for effect in effects])
    slices = [
        slice(int(end) - len(effect.coefficients), int(end))
        for end, effect in zip(ends, effects, strict=True)
    ]
    n = len(pool)
    return Columns(
        list(zip(pool, slices[:n], strict=True)),
        E,
        [(effect, where, touched) for (effect, touched), where in zip(always, slices[n:], strict=True)],
    )


def _changes(dataset: Dataset) -> list[tuple[Effect, Array]]:
    everywhere = np.ones(dataset.n_poses, dtype=bool)
    found: list[tuple[Effect, Array]] = [
        (SensorSlip(_ALWAYS, turns=dataset.sensor.kind == "line-laser"), everywhere)
    ]
    if dataset.sensor.kind != "tracker":
        for k in np.unique(dataset.plane_index):
            name = dataset.planes[k].name
            effect = PlaneMoved(name, _ALWAYS, None, plane_centre(dataset, name))
            found.append((effect, dataset.plane_index == k))
    return found


def rank(state: State, background: Background, cols: Columns) -> list[Scored]:
    """Return every candidate and change with its score, best first."""
    beside = Projected.of(background, cols.E, cols.gram, cols.sizes)
    families = Counter(candidate.effect.name for candidate, _ in cols.tried)
    scored = []
    for members in cols.by_width.values():
        groups = np.array([np.arange(where.start, where.stop) for _, where in members])
        gain, dof, observability = beside.score(groups)
        for k, (candidate, where) in enumerate(members):
            effect, own_gain, own_dof = candidate.effect, float(gain[k]), int(dof[k])
            chosen: list[int] = []
            if candidate.terms > 1:
                rest, freedom = remainder(background, own_gain, own_dof)
                terms = np.arange(where.start, where.stop).reshape(candidate.terms, -1)
                # Each term has to pay for its columns and for being one of many, as it would have to alone.
                price = np.log(background.freedom) + 2 * np.log(candidate.terms) / terms.shape[1]
                chosen = beside.forward(terms, worth=price * rest / freedom)
                if not chosen:
                    continue
                own = beside.score(terms[sorted(chosen)].reshape(1, -1))
                effect, own_gain, own_dof = candidate.with_terms(chosen), float(own[0][0]), int(own[1][0])
            choices = comb(candidate.terms, len(chosen)) if candidate.terms > 1 else 1
            family = families[effect.name] * choices
            scored.append(
                _scored(
                    background,
                    effect,
                    own_gain,
                    own_dof,
                    float(observability[k]),
                    family,
                    cols.total * choices,
                )
            )
    scored += _rank_changes(state, background, cols, cols.total)
    return sorted(scored, key=lambda entry: -entry.evidence)


def _rank_changes(state: State, background: Background, cols: Columns, total: int) -> list[Scored]:
    N, m = background.residual.shape
    order = state.residuals.poses.order
    time = state.residuals.poses.columns.get("time")
    scored = []
    for effect, where, touched in cols.changes:
        E = cols.E[: N * m, where].reshape(N, m, -1)
        found = score_changes(background, E, touched, effect.plausible_sizes, CHANGE_MARGIN)
        if not len(found.gain):
            continue
        best = int(np.argmax(found.gain))
        i = int(found.first[best])
        moment = {"order": float(order[i]), "time": None if time is None else float(time[i])}
        assert isinstance(effect, (SensorSlip, PlaneMoved))
        at = replace(effect, **moment, coefficients=np.zeros(len(effect.coefficients)))
        scored.append(
            _scored(
                background, at, float(found.gain[best]), int(found.dof[best]), 1.0, len(found.gain), total
            )
        )
    return scored


def _scored(
    background: Background,
    effect: Effect,
    gain: float,
    dof: int,
    observability: float,
    family: int,
    total: int,
) -> Scored:
    corrected = min(1.0, max(p_value(background, gain, dof), _LEAST_P_VALUE) * total)
    return Scored(effect, gain, dof, evidence(background, gain, dof, family), corrected, observability)


def merged(effects: Sequence[Effect], new: Effect) -> tuple[Effect, ...]:
    """Return effects with a new one: terms of the same compliance and orders of the same joint become one effect."""
    result = list(effects)
    for i, old in enumerate(result):
        if isinstance(old, JointHarmonic) and isinstance(new, JointHarmonic) and old.joint == new.joint:
            result[i] = _with_known(JointHarmonic(old.joint, tuple(sorted({*old.orders, *new.orders}))), old)
            return tuple(result)
        if isinstance(old, JointCompliance) and isinstance(new, JointCompliance):
            result[i] = _with_known(JointCompliance(tuple(sorted({*old.terms, *new.terms}))), old)
            return tuple(result)
        if isinstance(old, BaseCompliance) and isinstance(new, BaseCompliance):
            frames = tuple(sorted({*old.frames, *new.frames}))
            result[i] = _with_known(BaseCompliance(frames, old.alike and new.alike), old)
            return tuple(result)
    return (*result, new)


def _with_known(effect: Effect, old: Effect) -> Effect:
    known = dict(zip(_full_names(old), old.coefficients, strict=True))
    return effect.with_coefficients([known.get(name, 0.0) for name in _full_names(effect)])


def _full_names(effect: Effect) -> list[str]:
    if isinstance(effect, JointHarmonic):
        return [f"{f}{k}" for k in effect.orders for f in ("sin", "cos")]
    return effect.coefficient_names


@dataclass(frozen=True, eq=False)
class Found:
    """Where a hunt ended.

    Attributes:
        before: The state without effects, and its held-out errors.
        after: The state with all effects that were found, and its held-out errors.
        steps: For each effect in the order of taking: its score when it was taken, held-out errors before and after.
    """

    before: State
    held_out_before: HeldOut
    after: State
    held_out_after: HeldOut
    steps: list[tuple[Scored, HeldOut, HeldOut]]


def hunt(state: State) -> Found:
    """Return the state with every effect that the data bear out."""
    pool = candidates(state.dataset)
    start, start_error = state, held_out(state)
    error = start_error
    steps: list[tuple[Scored, HeldOut, HeldOut]] = []
    refused: set[str] = set()
    if start.background().variance < ROUNDING:
        return Found(start, start_error, state, error, steps)
    for _ in range(MAX_EFFECTS):
        ranking = rank(state, state.background(), columns(state, pool))
        taken = None
        for entry in ranking[:8]:
            if entry.p_value > ALPHA or entry.evidence <= 0:
                break
            if label(entry.effect) in refused:
                continue
            trial = settle(
                state.dataset, state.model, state.geometry_free, merged(state.effects, entry.effect)
            )
            trial_error = held_out(trial)
            if improvement(held_out(state, state.mix), held_out(trial, state.mix)) < LEAST_IMPROVEMENT:
                refused.add(label(entry.effect))
                continue
            taken = (entry, trial, trial_error)
            break
        if taken is None:
            break
        entry, trial, trial_error = taken
        steps.append((entry, error, trial_error))
        state = reconsidered(trial, pool)
        error = held_out(state)
    return Found(start, start_error, state, error, steps)


def reconsidered(state: State, pool: Sequence[Candidate]) -> State:
    """Return a state in which every effect earns its place and none could be replaced by a better one."""
    for _ in range(4 + len(state.effects)):
        changed = False
        cols = columns(state, pool)
        for i, effect in enumerate(state.effects):
            others = tuple(e for k, e in enumerate(state.effects) if k != i)
            own, ranking = rivals(state, i, cols)
            if own.evidence <= 0 or own.p_value > ALPHA:
                state, changed = settle(state.dataset, state.model, state.geometry_free, others), True
                break
            best = ranking[0]
            if label(best.effect) != label(effect) and best.evidence > own.evidence + SWAP_MARGIN:
                trial = settle(state.dataset, state.model, state.geometry_free, merged(others, best.effect))
                if trial.background().squared < state.background().squared + 1e-9 or best.dof < own.dof:
                    state, changed = trial, True
                    break
        if not changed:
            break
    return state


def rivals(state: State, i: int, cols: Columns) -> tuple[Scored, list[Scored]]:
    """Return how effect i of a state scores beside the others, and how everything else would score in its place."""
    without, mine, free = background_without(state, i)
    ranking = rank(state, without, cols)
    effect = state.effects[i]
    beside = Projected.of(without, mine, mine.T @ mine, effect.plausible_sizes[free])
    gain, dof, observability = (x[0] for x in beside.score(np.arange(mine.shape[1])[None]))
    family = sum(c.effect.name == effect.name for c, _ in cols.tried) or state.dataset.n_poses
    return _scored(without, effect, float(gain), int(dof), float(observability), family, cols.total), ranking


def background_without(state: State, i: int) -> tuple[Background, Array, Array]:
    """Return the background of a state without its effect i, that effect's free columns ``(N m, k)`` and which those are."""
    residual, jacobian = state.residuals.linearise(state.model)
    start = state.model.blocks["effects"].start + sum(len(e.coefficients) for e in state.effects[:i])
    mine = np.zeros(jacobian.shape[1], dtype=bool)
    where = slice(start, start + len(state.effects[i].coefficients))
    mine[where] = state.free[where]
    rest = residual - jacobian[:, mine] @ state.model.vector[mine]
    measured = state.dataset.n_poses * state.residuals.measurement.rows_per_pose
    background = state.background_of(rest, jacobian[:, state.free & ~mine])
    return background, mixed(state.mix, jacobian[:measured, mine]), state.free[where]


def label(effect: Effect) -> str:
    """Return name and target as one text; the same for effects that would be reported as the same."""
    if isinstance(effect, (JointCompliance, BaseCompliance)):
        return effect.name
    if isinstance(effect, (SensorSlip, PlaneMoved)):
        return effect.key
    return f"{effect.name} {effect.target}"


def same_place(a: Effect, b: Effect) -> bool:
    """Return whether two effects are the same but for their terms: orders of one joint, frames of a compliance, nearby moments."""
    if type(a) is not type(b):
        return False
    if (
        isinstance(a, JointHarmonic)
        and isinstance(b, JointHarmonic)
        and min(len(a.orders), len(b.orders)) > 1
    ):
        return a.joint == b.joint
    if isinstance(a, PlaneMoved) and isinstance(b, PlaneMoved):
        return a.plane == b.plane
    return isinstance(a, (SensorSlip, BaseCompliance, JointCompliance)) or label(a) == label(b)
