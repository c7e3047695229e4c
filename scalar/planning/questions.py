"""The questions that a diagnosis leaves open: effects that it could not distinguish from others, and effects that it could not see."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from scalar.data.dataset import Dataset
from scalar.data.io.atomic import plain
from scalar.effects import Effect, registry
from scalar.estimation.model import Model
from scalar.geometry.se3 import Array
from scalar.planning.information import linearised_at, prior_std, whitened_rows
from scalar.planning.separation import Question
from scalar.planning.workcell import Workcell


@dataclass(frozen=True, eq=False)
class Pair:
    """An effect, and a rival that may take its place.

    Attributes:
        effect: With coefficients of the size in question.
        rival: None where the effect left no residual at all.
    """

    effect: Effect
    rival: Effect | None

    @property
    def title(self) -> str:
        """Return what is asked."""
        return self.effect.title if self.rival is None else f"{self.effect.title} or {self.rival.title}"


@dataclass(frozen=True, eq=False)
class Asked:
    """What is asked of further poses, and what is known already.

    Attributes:
        questions: In terms of the columns of ``rows``.
        start: ``(P, P)``, information of the measured poses and of weak priors.
        rows: ``(N, m, P)``, of the candidates.
    """

    questions: list[Question]
    start: Array
    rows: Array


def open_pairs(
    diagnosis: Mapping[str, Any], found: Sequence[Effect], dataset: Dataset
) -> tuple[list[Pair], list[str]]:
    """Return the pairs that a diagnosis left open, and what of it poses cannot answer, in words.

    Args:
        diagnosis: Content of ``diagnosis.json``.
        found: Effects of the calibration after it.
        dataset: That was diagnosed.
    """
    pool = [effect for kind in registry.known().values() for effect in kind.candidates(dataset)]
    pairs: list[Pair] = []
    beyond: list[str] = []

    def wanted(entry: Mapping[str, Any]) -> Effect | None:
        return next((e for e in (*found, *_each(pool)) if _is(e, entry)), None)

    for entry in with_doubtful(diagnosis["effects"]):
        for other in entry["confounded_with"]:
            effect, rival = wanted(entry), wanted(other)
            if effect is None or rival is None or not _by_poses(effect, rival):
                beyond.append(f"{_named(entry)} or {_named(other)}")
                continue
            pair = Pair(_sized(effect, entry), rival)
            if not any(
                _same_pair(pair, known) for known in pairs
            ):  # terms of one rival are listed one by one
                pairs.append(pair)
    for entry in diagnosis.get("unobservable", diagnosis.get("silent", ())):
        effect = _as_written(entry) or wanted(entry)
        if effect is None or not effect.natural_sizes.any() or not _by_poses(effect):
            beyond.append(_named(entry))
            continue
        pairs.append(Pair(effect.with_coefficients(effect.natural_sizes), None))
    return pairs, list(dict.fromkeys(beyond))


def with_doubtful(effects: Sequence[Mapping[str, Any]]) -> list[Mapping[str, Any]]:
    """Return the entries of a diagnosis, and those that it gives no name but says what they are most like."""
    return [found for entry in effects for found in (entry, *entry.get("most_like", ()))]


def asked(
    cell: Workcell, pairs: Sequence[Pair], dataset: Dataset, candidates: Dataset, misfit: float
) -> Asked:
    """Return the questions in terms of one model with all effects in question, and what poses tell of it.

    Args:
        cell: Near the calibration after the diagnosis.
        pairs: To separate.
        dataset: That was diagnosed.
        candidates: Poses with what the sensor would measure.
        misfit: The residual's real size in units of the noise.
    """
    base = cell.model.effects
    more: list[Effect] = []
    for effect in (e for pair in pairs for e in (pair.effect, pair.rival) if e is not None):
        if not any(_same(effect, other) for other in (*base, *more)):
            more.append(effect.with_coefficients(0 * effect.coefficients))
    model = replace(cell.model, effects=(*base, *more))
    measured = replace(dataset, sensor=cell.sensor, planes=cell.planes)
    (old, names), (new, names_new) = (_rows(model, d, cell.repeatability) for d in (measured, candidates))
    every = list(dict.fromkeys([*names, *names_new]))
    old, new = (_placed(rows, own, every) / misfit for rows, own in ((old, names), (new, names_new)))
    prior = _priors(model, every)
    start = np.diag(1.0 / prior**2) + np.einsum("nmp,nmq->pq", old, old)
    where = dict(zip(map(id, model.effects), model.effect_names, strict=True))

    def columns(effect: Effect) -> Array:
        own = next(e for e in model.effects if _same(e, effect))
        return np.array([every.index(name) for name in where[id(own)]], dtype=int)

    of_effects = {name for own in model.effect_names for name in own}
    geometry = np.array([i for i, n in enumerate(every) if n not in of_effects and not n.startswith("beta_")])
    questions = []
    for pair in pairs:
        beside = [e for e in base if not _same(e, pair.effect)]
        beside += [] if pair.rival is None or any(_same(pair.rival, e) for e in beside) else [pair.rival]
        rest = np.concatenate([geometry, *(columns(e) for e in beside)])
        questions.append(Question(pair.title, columns(pair.effect), rest, pair.effect.coefficients))
    return Asked(questions, start, new)


def _rows(model: Model, poses: Dataset, repeatability: float) -> tuple[Array, list[str]]:
    residuals, here = linearised_at(model, poses)
    return whitened_rows(residuals, here, repeatability), here.names


def _placed(rows: Array, names: list[str], every: list[str]) -> Array:
    placed = np.zeros((*rows.shape[:2], len(every)))
    placed[:, :, [every.index(name) for name in names]] = rows
    return placed


def _priors(model: Model, every: list[str]) -> Array:
    known = dict(zip(model.names, prior_std(model), strict=True))
    typical = float(np.median(list(known.values())))
    return np.array([known.get(name, typical) for name in every])


def _each(pool: Sequence[Effect]) -> list[Effect]:
    """Return the candidates, and the single terms of those that have several."""
    single = [e.with_terms([i]) for e in pool if e.n_terms > 1 for i in range(e.n_terms)]
    return [*pool, *single]


def _is(effect: Effect, entry: Mapping[str, Any]) -> bool:
    return effect.name == entry["name"] and plain(effect.target) == entry["target"]


def _as_written(entry: Mapping[str, Any]) -> Effect | None:
    """Return the effect that an entry describes with its settings, None where it has none or the kind is absent."""
    kind = registry.known().get(entry["name"])
    return kind.from_mapping(entry["settings"]) if kind is not None and "settings" in entry else None


def _same(one: Effect, other: Effect) -> bool:
    alike = one.name == other.name and one.target == other.target and one.term_names == other.term_names
    return alike and _words(one) == _words(other)


def _words(effect: Effect) -> dict[str, str]:
    """Return the settings that are words, as by what the side of a backlash is told; numbers are estimates."""
    return {key: value for key, value in effect.to_mapping().items() if isinstance(value, str)}


def _same_pair(one: Pair, other: Pair) -> bool:
    assert one.rival is not None
    return other.rival is not None and _same(one.effect, other.effect) and _same(one.rival, other.rival)


def _by_poses(*effects: Effect) -> bool:
    """Return whether other joint angles may separate effects: changes in time need another time."""
    return not any(effect.is_change_in_time for effect in effects)


def _sized(effect: Effect, entry: Mapping[str, Any]) -> Effect:
    """Return an effect of the size that was found."""
    if effect.coefficients.any():
        return effect
    values = [entry["coefficients"].get(name, {}).get("value") for name in effect.coefficient_names]
    known = all(value is not None for value in values)
    return effect.with_coefficients([float(v) for v in values] if known else effect.natural_sizes)


def _named(entry: Mapping[str, Any]) -> str:
    place = " ".join(
        f"{key} {value}" for key, value in entry["target"].items() if not isinstance(value, dict)
    )
    return f"{entry['name']} {place}".strip()
