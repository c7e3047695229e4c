"""The questions that a diagnosis leaves open: effects that it could not distinguish from others, and effects that it could not observe.

A diagnosis keeps only those coefficients of an effect that its poses show. An example is the compliance of joint 2 if joint 3 hardly moved: the
torques of all links then vary like that of link 2 alone, a sine of the angle of joint 2, and so does the error of a gear. But the other links have
masses, and poses with another angle of joint 3 would show their torques. A question is therefore asked about the whole effect, with all its
coefficients. Of the coefficients that explain the measured poses as well as those found, the smallest are taken.
"""

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
    """An open question: an effect, and a rival that explains the data as well, or whether the effect acts at all.

    Attributes:
        effect: The effect, with coefficients of the size that was found, or of natural size.
        rival: The confounded effect; None if the question is whether the effect acts at all, because it was unobservable.
    """

    effect: Effect
    rival: Effect | None

    @property
    def title(self) -> str:
        """Return the question in words."""
        return self.effect.title if self.rival is None else f"{self.effect.title} or {self.rival.title}"


@dataclass(frozen=True, eq=False)
class OpenQuestions:
    """Questions about P parameters, the information on these that the measured poses give, and that of candidate poses.

    Attributes:
        questions: The questions; their indices refer to the P parameters.
        start: ``(P, P)``, information of the measured poses and of weak priors.
        rows: ``(N, m, P)``, whitened rows of the candidate poses.
    """

    questions: list[Question]
    start: Array
    rows: Array


def open_pairs(
    diagnosis: Mapping[str, Any], found: Sequence[Effect], dataset: Dataset
) -> tuple[list[Pair], list[str]]:
    """Return the pairs that a diagnosis left open, and in words the questions that further poses cannot answer.

    Args:
        diagnosis: Content of ``diagnosis.json``.
        found: Effects of the calibration ``after.json``.
        dataset: The dataset that was diagnosed.
    """
    pool = [effect for kind in registry.known().values() for effect in kind.candidates(dataset)]
    pairs: list[Pair] = []
    not_by_poses: list[str] = []

    def effect_of(entry: Mapping[str, Any]) -> Effect | None:
        return next((e for e in (*found, *_with_single_terms(pool)) if _matches(e, entry)), None)

    for entry in with_doubtful(diagnosis["effects"]):
        for other in entry["confounded_with"]:
            effect, rival = effect_of(entry), effect_of(other)
            if effect is None or rival is None or not _separable_by_poses(effect, rival):
                not_by_poses.append(f"{_named(entry)} or {_named(other)}")
                continue
            pair = Pair(with_all_terms(_with_found_size(effect, entry), pool), rival)
            # A diagnosis lists the terms of one rival one by one, which makes the same pair several times.
            if not any(_same_pair(pair, known) for known in pairs):
                pairs.append(pair)
    for entry in diagnosis.get("unobservable", diagnosis.get("silent", ())):
        effect = _from_settings(entry) or effect_of(entry)
        if effect is None or not effect.natural_sizes.any() or not _separable_by_poses(effect):
            not_by_poses.append(_named(entry))
            continue
        pairs.append(Pair(effect.with_coefficients(effect.natural_sizes), None))
    return pairs, list(dict.fromkeys(not_by_poses))


def with_doubtful(effects: Sequence[Mapping[str, Any]]) -> list[Mapping[str, Any]]:
    """Return the entries of a diagnosis; an entry without a certain name is followed by the effects that it is most like."""
    return [found for entry in effects for found in (entry, *entry.get("most_like", ()))]


def open_questions(
    workcell: Workcell, pairs: Sequence[Pair], dataset: Dataset, candidates: Dataset, misfit: float
) -> OpenQuestions:
    """Return the questions about the parameters of one model with all effects in question, and the information of poses on these.

    Args:
        workcell: The workcell near the calibration after the diagnosis.
        pairs: The pairs to separate.
        dataset: The dataset that was diagnosed.
        candidates: Candidate poses with what the sensor would measure there.
        misfit: Ratio of the residual to the stated noise, by which the information of all poses is reduced.
    """
    base = with_terms_of_pairs(workcell.model.effects, pairs)
    asked_for = [e for pair in pairs for e in (pair.effect, pair.rival) if e is not None]
    model = replace(workcell.model, effects=with_zero(base, asked_for))
    measured = replace(dataset, sensor=workcell.sensor, planes=workcell.planes)
    old, names = _rows(model, measured, workcell.repeatability, measured=True)
    new, names_new = _rows(model, candidates, workcell.repeatability, measured=False)
    all_names = list(dict.fromkeys([*names, *names_new]))
    old, new = (_spread(rows, own, all_names) / misfit for rows, own in ((old, names), (new, names_new)))
    prior = _priors(model, all_names)
    start = np.diag(1.0 / prior**2) + np.einsum("nmp,nmq->pq", old, old)
    names_of = dict(zip(map(id, model.effects), model.effect_names, strict=True))

    def columns(effect: Effect) -> Array:
        # Two flexible terms of the same kind at different links are alike in all but numbers, so an effect of the model is looked for itself first.
        alike = [e for e in model.effects if same_effect(e, effect)]
        own = next((e for e in alike if e is effect), alike[0])
        return np.array([all_names.index(name) for name in names_of[id(own)]], dtype=int)

    of_effects = {name for own in model.effect_names for name in own}
    of_no_effect = [i for i, name in enumerate(all_names) if name not in of_effects]
    without_beta = np.array([i for i in of_no_effect if not all_names[i].startswith("beta_")])
    questions = []
    for pair in pairs:
        others = [e for e in base if not same_effect(e, pair.effect)]
        others += (
            [] if pair.rival is None or any(same_effect(pair.rival, e) for e in others) else [pair.rival]
        )
        rest = np.concatenate([without_beta, *(columns(e) for e in others)])
        own = columns(pair.effect)
        size = pair.effect.coefficients
        if any(with_all_terms(e, [pair.effect]) is not e for e in workcell.model.effects):
            size = _least(old[:, :, own].reshape(-1, len(own)), size)
        questions.append(Question(pair.title, own, rest, size))
    return OpenQuestions(questions, start, new)


def with_all_terms(effect: Effect, pool: Sequence[Effect]) -> Effect:
    """Return an effect widened to all coefficients that the candidate of its name and target has; the added ones are zero."""
    terms = set(effect.term_names)
    wider = [
        e for e in pool if e.name == effect.name and e.target == effect.target and terms < set(e.term_names)
    ]
    return min(wider, key=lambda e: e.n_terms).with_coefficients_of(effect) if wider else effect


def with_terms_of_pairs(effects: Sequence[Effect], pairs: Sequence[Pair]) -> tuple[Effect, ...]:
    """Return effects; where a pair has the same effect with more coefficients, that one is returned instead."""
    asked_for = [pair.effect for pair in pairs]
    return tuple(
        next((wide for wide in asked_for if with_all_terms(effect, [wide]) is not effect), effect)
        for effect in effects
    )


def with_zero(base: Sequence[Effect], further: Sequence[Effect]) -> tuple[Effect, ...]:
    """Return the effects of ``base``, followed by the further effects that are not among them, each once and with coefficients of zero."""
    effects = list(base)
    for effect in further:
        if not any(same_effect(effect, other) for other in effects):
            effects.append(effect.with_coefficients(0 * effect.coefficients))
    return tuple(effects)


def _least(rows: Array, found: Array) -> Array:
    """Return the smallest coefficients ``(k,)`` with which an effect explains the measured poses as well as with those found.

    Args:
        rows: ``(R, k)``, whitened rows of the measured poses by the effect's coefficients.
        found: ``(k,)``; zero where the diagnosis left a coefficient out.
    """
    prior = float(np.sqrt(np.mean(found[found != 0] ** 2)))
    gram = rows.T @ rows
    return np.linalg.solve(gram + np.eye(len(found)) / prior**2, gram @ found)


def _rows(model: Model, poses: Dataset, repeatability: float, *, measured: bool) -> tuple[Array, list[str]]:
    """Return the whitened rows of poses ``(N, m, P)``, and the names of their P parameters; ``measured`` as for ``linearised_at``."""
    residuals, model = linearised_at(model, poses, measured=measured)
    return whitened_rows(residuals, model, repeatability), model.names


def _spread(rows: Array, names: list[str], all_names: list[str]) -> Array:
    """Return rows with a column for each of all parameters, zero for those that are not among ``names``."""
    spread = np.zeros((*rows.shape[:2], len(all_names)))
    spread[:, :, [all_names.index(name) for name in names]] = rows
    return spread


def _priors(model: Model, all_names: list[str]) -> Array:
    """Return the prior standard deviation of each parameter; one that the model lacks gets the median of the others."""
    known = dict(zip(model.names, prior_std(model), strict=True))
    typical = float(np.median(list(known.values())))
    return np.array([known.get(name, typical) for name in all_names])


def _with_single_terms(pool: Sequence[Effect]) -> list[Effect]:
    """Return effects, and the single terms of those that have several."""
    single = [e.with_terms([i]) for e in pool if e.n_terms > 1 for i in range(e.n_terms)]
    return [*pool, *single]


def _matches(effect: Effect, entry: Mapping[str, Any]) -> bool:
    """Return whether an entry of a diagnosis has the name and the target of an effect."""
    return effect.name == entry["name"] and plain(effect.target) == entry["target"]


def _from_settings(entry: Mapping[str, Any]) -> Effect | None:
    """Return the effect that an entry describes by its settings; None where it has none or the kind of effect is unknown."""
    kind = registry.known().get(entry["name"])
    return kind.from_mapping(entry["settings"]) if kind is not None and "settings" in entry else None


def same_effect(one: Effect, other: Effect) -> bool:
    """Return whether two effects have the same columns; their coefficients may differ."""
    alike = one.name == other.name and one.target == other.target and one.term_names == other.term_names
    return alike and _text_settings(one) == _text_settings(other)


def _text_settings(effect: Effect) -> dict[str, str]:
    """Return the settings of an effect that are text, such as how the side of a backlash is known; settings that are numbers are estimates."""
    return {key: value for key, value in effect.to_mapping().items() if isinstance(value, str)}


def _same_pair(one: Pair, other: Pair) -> bool:
    assert one.rival is not None
    return (
        other.rival is not None
        and same_effect(one.effect, other.effect)
        and same_effect(one.rival, other.rival)
    )


def _separable_by_poses(*effects: Effect) -> bool:
    """Return whether planned poses may separate effects: a change in time needs another time, and torques are not known before they are recorded."""
    return not any(effect.is_change_in_time or effect.needs_records for effect in effects)


def _with_found_size(effect: Effect, entry: Mapping[str, Any]) -> Effect:
    """Return an effect with its own coefficients, else with those of the diagnosis, else of its natural size."""
    if effect.coefficients.any():
        return effect
    values = [entry["coefficients"].get(name, {}).get("value") for name in effect.coefficient_names]
    known = all(value is not None for value in values)
    return effect.with_coefficients([float(v) for v in values] if known else effect.natural_sizes)


def _named(entry: Mapping[str, Any]) -> str:
    """Return name and target of an entry, as text."""
    place = " ".join(
        f"{key} {value}" for key, value in entry["target"].items() if not isinstance(value, dict)
    )
    return f"{entry['name']} {place}".strip()
