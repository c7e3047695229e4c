"""The hunt: score every candidate, add the best, refit everything, judge on held-out poses, repeat; then ask whether another would do as well.

A candidate is taken if its gain is beyond chance, corrected for all that were tried, and if it lowers the error on held-out poses. After every
step what is already in the model must still earn its place, and may be replaced by what explains the same better, so that the order in which
effects are found does not decide the answer.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import comb, prod
from typing import TYPE_CHECKING

import numpy as np

from scalar.diagnosis.candidate_set import Candidate, candidates
from scalar.diagnosis.fitted_state import State, mixed, settle
from scalar.diagnosis.hold_out import held_out, improvement, no_worse
from scalar.diagnosis.score_test import (
    Background,
    ChangeScores,
    Moments,
    Projected,
    beside,
    evidence,
    p_value,
    remainder,
)
from scalar.effects.base import BaseCompliance
from scalar.effects.catalogue import plane_centre
from scalar.effects.effect import Effect
from scalar.effects.joints import JointCompliance, JointHarmonic
from scalar.effects.sensor import SensorSlip
from scalar.effects.surface import PlaneMoved
from scalar.estimation.model import JointBasis
from scalar.geometry.se3 import Array

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset

ALPHA = 1e-3  # chance of taking an effect where there is none, corrected for all that were tried
LEAST_IMPROVEMENT = 2.0  # standard errors by which the held-out error has to fall
SWAP_MARGIN = 3.0  # nats of evidence by which another effect has to explain better to take a place
CONFOUNDED_MARGIN = 5.0  # nats within which the data do not tell two effects apart
MAX_EFFECTS = 60  # steps; harmonics of several joints take many
CHANGE_MARGIN = 6  # least number of poses on each side of a change
REFINEMENTS = (1.0, 0.5, 0.25)  # of the steps of a first look
TRIED = 8  # candidates that are added to see whether held-out poses bear them out, before the hunt gives up
LOOKS = 3  # with steps of each size
LEAST_GAIN = 0.05  # nats, for another look
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
class Bank:
    """What is tried on a dataset, in elements: columns that several candidates share stand there once.

    Attributes:
        tried: Candidates with the indices of their columns.
        elements: Effects whose columns these are.
        changes: (effect that acts always, the poses it touches) for every kind of change; their columns come last.
        bases: What effects on joints are of the poses, filled as they are first asked for.
        elsewhere: How many more of the same kind are tried in other banks.
    """

    tried: list[tuple[Candidate, Array]]
    elements: list[Effect]
    changes: list[tuple[Effect, Array]]
    bases: dict[Effect, JointBasis] = field(default_factory=dict)
    elsewhere: int = 0

    @classmethod
    def of(
        cls, pool: Sequence[Candidate], changes: Sequence[tuple[Effect, Array]] = (), elsewhere: int = 0
    ) -> Bank:
        """Return the bank of a pool of candidates and kinds of change."""
        elements: list[Effect] = []
        where: dict[str, Array] = {}
        tried, width = [], 0
        for candidate in pool:
            indices = []
            for element in candidate.elements():
                key = f"{type(element).__name__} {element.to_mapping()}"
                if key not in where:
                    where[key] = width + np.arange(len(element.coefficients))
                    width += len(element.coefficients)
                    elements.append(element)
                indices.append(where[key])
            tried.append((candidate, np.concatenate(indices)))
        return cls(tried, elements, list(changes), elsewhere=elsewhere)

    @cached_property
    def effects(self) -> list[Effect]:
        """Return the elements and the changes."""
        return [*self.elements, *(effect for effect, _ in self.changes)]

    @cached_property
    def sizes(self) -> Array:
        """Return the plausible size of every coefficient."""
        return np.concatenate([np.zeros(0), *(effect.plausible_sizes for effect in self.effects)])

    @cached_property
    def by_width(self) -> dict[int, list[tuple[Candidate, Array]]]:
        """Return the candidates by their number of columns."""
        result: dict[int, list[tuple[Candidate, Array]]] = {}
        for candidate, where in self.tried:
            result.setdefault(len(where), []).append((candidate, where))
        return result

    @property
    def total(self) -> int:
        """Return how many candidates and moments are tried."""
        return len(self.tried) + self.elsewhere + sum(int(touched.sum()) for _, touched in self.changes)


def bank(dataset: Dataset) -> Bank:
    """Return everything with a name that may be tried on a dataset."""
    return Bank.of(candidates(dataset), _changes(dataset))


class Columns:
    """The whitened columns of a bank at a state's model, and what follows from them without another pass over the rows."""

    def __init__(self, state: State, bank: Bank) -> None:
        """Take the columns.

        Args:
            state: Fitted.
            bank: What is tried.
        """
        self.bank = bank
        self.full = state.background()
        self.E = state.columns_of(bank.effects, bank.bases)
        own = self.E.T @ self.E
        self.squared = np.diag(own).copy()
        self.gram = beside(self.full, self.E, own)
        self.moments: dict[int, Moments] = {}

    def projected(self, background: Background) -> Projected:
        """Return the columns beside the state's background, or beside it without some of its columns."""
        gram = self.gram
        if background.released is not None:
            B = background.released.T @ self.E
            gram = gram + B.T @ B
        return Projected.with_gram(background, self.E, gram, self.squared, self.bank.sizes)

    def changes(self, background: Background) -> list[tuple[Effect, ChangeScores]]:
        """Return the scores of every kind of change at every moment."""
        N, m = background.residual.shape
        found = []
        at = self.E.shape[1] - sum(len(effect.coefficients) for effect, _ in self.bank.changes)
        for i, (effect, touched) in enumerate(self.bank.changes):
            k = len(effect.coefficients)
            E = self.E[: N * m, at : at + k].reshape(N, m, k)
            at += k
            if i not in self.moments:
                self.moments[i] = Moments.of(self.full, E, np.flatnonzero(touched), CHANGE_MARGIN)
            found.append((effect, self.moments[i].score(background, E, effect.plausible_sizes)))
        return found


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
    beside, tried, total = cols.projected(background), cols.bank.tried, cols.bank.total
    families = Counter(candidate.effect.name for candidate, _ in tried)
    scored = []
    for members in cols.bank.by_width.values():
        groups = np.array([where for _, where in members])
        gain, dof, observability = beside.score(groups)
        for k, (candidate, where) in enumerate(members):
            effect, own_gain, own_dof = candidate.effect, float(gain[k]), int(dof[k])
            chosen: list[int] = []
            if candidate.terms > 1:
                rest, freedom = remainder(background, own_gain, own_dof)
                terms = where.reshape(candidate.terms, -1)
                # Each term has to pay for its columns and for being one of many, as it would have to alone.
                price = np.log(background.freedom) + 2 * np.log(candidate.terms) / terms.shape[1]
                chosen = beside.forward(terms, worth=price * rest / freedom)
                if not chosen:
                    continue
                own = beside.score(terms[sorted(chosen)].reshape(1, -1))
                effect, own_gain, own_dof = candidate.with_terms(chosen), float(own[0][0]), int(own[1][0])
            choices = comb(candidate.terms, len(chosen)) if candidate.terms > 1 else 1
            family = (families[effect.name] + cols.bank.elsewhere) * choices
            scored.append(
                _scored(
                    background,
                    effect,
                    own_gain,
                    own_dof,
                    float(observability[k]),
                    family,
                    total * choices,
                )
            )
    scored += _rank_changes(state, background, cols)
    return sorted(scored, key=lambda entry: -entry.evidence)


def _rank_changes(state: State, background: Background, cols: Columns) -> list[Scored]:
    order = state.residuals.poses.order
    time = state.residuals.poses.columns.get("time")
    scored = []
    for effect, found in cols.changes(background):
        if not len(found.gain):
            continue
        best = int(np.argmax(found.gain))
        i = int(found.first[best])
        moment = {"order": float(order[i]), "time": None if time is None else float(time[i])}
        assert isinstance(effect, (SensorSlip, PlaneMoved))
        at = replace(effect, **moment, coefficients=np.zeros(len(effect.coefficients)))
        gain, dof = float(found.gain[best]), int(found.dof[best])
        scored.append(_scored(background, at, gain, dof, 1.0, len(found.gain), cols.bank.total))
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
        if (
            isinstance(old, JointHarmonic)
            and isinstance(new, JointHarmonic)
            and type(old) is type(new)
            and old.joint == new.joint
        ):
            result[i] = _with_known(type(old)(old.joint, tuple(sorted({*old.orders, *new.orders}))), old)
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


def hunt(state: State, bank: Bank) -> State:
    """Return the state with every effect of a bank that the data bear out."""
    if state.background().variance < ROUNDING:
        return state
    refused: set[str] = set()
    cols = Columns(state, bank)
    for _ in range(MAX_EFFECTS):
        better = _better(state, cols, refused)
        if better is None:
            break
        state, cols = reconsidered(better, bank)
    return state


def _better(state: State, cols: Columns, refused: set[str]) -> State | None:
    """Return the state with the best candidate that poses held out bear out, or None; those they do not bear out are refused from now on."""
    before, before_mixed = held_out(state), held_out(state, state.mix)
    for entry in _best(state, cols):
        if label(entry.effect) in refused:
            continue
        trial = settle(state.dataset, state.model, state.geometry_free, merged(state.effects, entry.effect))
        gain = improvement(before_mixed, held_out(trial, state.mix))
        if gain >= LEAST_IMPROVEMENT and no_worse(before, held_out(trial)):
            return trial
        refused.add(label(entry.effect))
    return None


def _best(state: State, cols: Columns) -> list[Scored]:
    """Return the few candidates that are beyond chance and explain most, refined, best first."""
    background = state.background()
    worth = [e for e in rank(state, background, cols)[:TRIED] if e.p_value <= ALPHA and e.evidence > 0]
    return sorted((refined(state, background, e) for e in worth), key=lambda entry: -entry.evidence)


def refined(state: State, background: Background, entry: Scored) -> Scored:
    """Return a scored effect with what is not linear in it fitted: finer looks about the coarse one."""
    for scale in REFINEMENTS:
        for _ in range(LOOKS):
            finer = _look(state, background, entry, scale)
            if finer is entry:
                break
            entry = finer
    return entry


def _look(state: State, background: Background, entry: Scored, scale: float) -> Scored:
    """Return the best of an effect's variations, or the entry itself."""
    pool = Bank.of([Candidate(effect) for effect in entry.effect.variations(scale)])
    if len(pool.tried) == 1:
        return entry
    best = rank(state, background, Columns(state, pool))[0]
    # The price of the search is that of the coarse one; what is gained is fit.
    was, now = (max(background.squared - e.gain, 1e-300) for e in (entry, best))
    gained = float(0.5 * background.freedom * np.log(was / now))
    if gained < LEAST_GAIN:
        return entry
    return replace(
        entry,
        effect=_at_a_pose(best.effect, state),
        gain=best.gain,
        evidence=entry.evidence + gained,
    )


def _at_a_pose(effect: Effect, state: State) -> Effect:
    """Return a creep that begins at the first pose of its plate after where a finer look found it to begin."""
    if not isinstance(effect, PlaneMoved):
        return effect
    dataset, order = state.dataset, state.residuals.poses.order
    mine = np.flatnonzero(dataset.plane_index == [p.name for p in dataset.planes].index(effect.plane))
    i = mine[min(int(np.searchsorted(order[mine], effect.order)), len(mine) - 1)]
    time = state.residuals.poses.columns.get("time")
    span = effect.order + effect.creep_span - float(order[i])
    if span <= 0:
        return effect
    return replace(
        effect, order=float(order[i]), time=None if time is None else float(time[i]), creep_span=span
    )


def reconsidered(state: State, bank: Bank) -> tuple[State, Columns]:
    """Return a state in which every effect earns its place and none could be replaced by a better one, with its columns."""
    cols = Columns(state, bank)
    for _ in range(4 + len(state.effects)):
        changed = False
        for i, effect in enumerate(state.effects):
            others = tuple(e for k, e in enumerate(state.effects) if k != i)
            own, ranking = rivals(state, i, cols)
            if own.evidence <= 0 or own.p_value > ALPHA:
                state, changed = settle(state.dataset, state.model, state.geometry_free, others), True
                break
            best = ranking[0]
            if label(best.effect) != label(effect) and best.evidence > own.evidence + SWAP_MARGIN:
                trial = settle(state.dataset, state.model, state.geometry_free, merged(others, best.effect))
                better = trial.background().squared < state.background().squared + 1e-9
                if (better or best.dof < own.dof) and no_worse(held_out(state), held_out(trial)):
                    state, changed = trial, True
                    break
        if not changed:
            break
        cols = Columns(state, bank)
    return state, cols


def rivals(state: State, i: int, cols: Columns) -> tuple[Scored, list[Scored]]:
    """Return how effect i of a state scores beside the others, and how everything else would score in its place."""
    left_out = background_without(state, [i])
    return together(state, [i], cols.bank, left_out), rank(state, left_out[0], cols)


def together(
    state: State, indices: Sequence[int], bank: Bank, left_out: tuple[Background, Array, Array]
) -> Scored:
    """Return how effects of a state score beside the others, as one: by the first of them.

    Args:
        state: With the effects.
        indices: Which.
        bank: What is tried.
        left_out: As ``background_without`` gives it for these effects.
    """
    without, mine, sizes = left_out
    # Rows of priors apart, which no column of another effect has: what is left of the effects' own beside the others.
    assert without.released is not None
    left = without.released.T @ mine
    beside = Projected.with_gram(without, mine, left.T @ left, np.sum(mine * mine, axis=0), sizes)
    gain, dof, observability = (x[0] for x in beside.score(np.arange(mine.shape[1])[None]))
    effects = [state.effects[i] for i in indices]
    families = [sum(c.effect.name == e.name for c, _ in bank.tried) for e in effects]
    family = prod(count or state.dataset.n_poses for count in families)
    return _scored(without, effects[0], float(gain), int(dof), float(observability), family, bank.total)


def background_without(state: State, indices: Sequence[int]) -> tuple[Background, Array, Array]:
    """Return the background of a state without some effects, those effects' free columns ``(N m, k)`` and plausible sizes ``(k,)``."""
    local, sizes = columns_of_effects(state, indices)
    background = without_columns(state.background(), state, local, sizes)
    measured = state.dataset.n_poses * state.residuals.measurement.rows_per_pose
    return background, mixed(state.mix, state.linearised()[1][:measured, local]), sizes


def without_columns(background: Background, state: State, local: Array, sizes: Array) -> Background:
    """Return a background of a state without some of its free columns ``(F,)`` of plausible sizes ``(k,)``; finite ones have a prior each."""
    return background.without(local, state.model.vector[state.free][local], int(np.isfinite(sizes).sum()))


def columns_of_effects(state: State, indices: Sequence[int]) -> tuple[Array, Array]:
    """Return which of a state's free columns ``(F,)`` are those of some effects, and their plausible sizes ``(k,)``."""
    start = state.model.blocks["effects"].start
    ends = start + np.cumsum([0, *(len(effect.coefficients) for effect in state.effects)])
    mine = np.zeros(len(state.free), dtype=bool)
    sizes = np.full(len(state.free), np.inf)
    for i in indices:
        mine[ends[i] : ends[i + 1]] = True
        sizes[ends[i] : ends[i + 1]] = state.effects[i].plausible_sizes
    return mine[state.free], sizes[mine & state.free]


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


def same_answer(a: Effect, b: Effect) -> bool:
    """Return whether two effects say the same but for details: the same place, or orders of one joint that overlap."""
    if isinstance(a, JointHarmonic) and isinstance(b, JointHarmonic) and a.joint == b.joint:
        return bool(set(a.orders) & set(b.orders))
    return same_place(a, b)
