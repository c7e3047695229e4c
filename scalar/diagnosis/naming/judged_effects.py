"""Judge the effects of a run: what else might explain the data in the place of each effect, and how probable its name is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import expit

from scalar.diagnosis.explained import Explained
from scalar.diagnosis.fit.fitted_state import FittedState
from scalar.diagnosis.held_out.hold_out import HeldOutErrors, held_out_errors
from scalar.diagnosis.naming.akaike_rivals import (
    akaike_weight,
    compared_by_akaike,
    name_and_target,
    weight_among,
)
from scalar.diagnosis.naming.confidence import confidence
from scalar.diagnosis.naming.finding import Finding
from scalar.diagnosis.naming.fold_odds import WithoutFold, fold_odds, without_each_fold
from scalar.diagnosis.naming.grounds import FinalResiduals, Grounds, grounds_of_effect
from scalar.diagnosis.naming.refitted_rivals import with_fitted_rivals
from scalar.diagnosis.naming.repeated_changes import repeated_changes_doubted
from scalar.diagnosis.naming.rival_sets import CLEAR_ODDS, nearest_set
from scalar.diagnosis.scoring.candidate_columns import CandidateColumns
from scalar.diagnosis.scoring.conditional_scores import background_without, rivals, rivals_of_strongest_part
from scalar.diagnosis.scoring.merging import merged
from scalar.diagnosis.scoring.ranking import Scored, rank
from scalar.diagnosis.selection.harmonic_spectrum import has_all_orders, is_shrunk, priors_for_whitened_rows
from scalar.diagnosis.selection.instrument_errors import errors_of_instrument_in, leads_of_instrument
from scalar.diagnosis.settings import Settings
from scalar.diagnosis.structure.leads_of_terms import leads_of_terms
from scalar.diagnosis.structure.unmodelled_structure import evidence_without_a_name
from scalar.effects import Effect

_LIMITED_BY_STRUCTURE = (
    "unmodelled structure, or an error of the instrument, explains the residual about as well"
)
_LIMITED_BY_SETS = "two or three other effects together explain about as much"
NEAREST_RIVALS = 8  # number of rivals, those with the most evidence, with which an effect is compared again without each fold of the poses


def findings_of(run: Explained, final_residuals: FinalResiduals) -> tuple[Finding, ...]:
    """Return a finding for each effect of a run: its confidence, what it is confounded with, and the held-out errors without and with it.

    These errors are those of the models to which the effects are added one after the other, in their order.
    """
    before, after, candidates = run.before, run.after, run.candidates
    found: list[Finding] = []
    state, error_before = before, held_out_errors(before)
    effects: tuple[Effect, ...] = ()
    scored = priors_for_whitened_rows(after)
    columns = CandidateColumns.of(scored, candidates)
    folds = without_each_fold(scored) if after.effects else []
    without_a_name = evidence_without_a_name(scored, run.flexible_candidates)
    of_instrument = leads_of_instrument(after, run.rival, candidates)
    leads = np.maximum(leads_of_terms(scored, run.flexible_candidates), of_instrument)
    given_all = _scores_given_all(scored, columns) if after.effects else []
    for i, effect in enumerate(after.effects):
        effects = merged(effects, effect)
        last = i + 1 == len(after.effects) and len(effects) == len(after.effects)
        state = after if last else after.refitted(effects, state.model)
        errors = error_before, held_out_errors(state)
        found.append(
            _finding(after, scored, i, columns, given_all, folds, without_a_name[i], errors, final_residuals)
        )
        if not effect.flexible:
            most, least = float(expit(-leads[i])), after.settings.naming.least_confidence
            found[-1] = found[-1].limited(most, least, _LIMITED_BY_STRUCTURE)
            found[-1] = _compared_with_sets(found[-1], scored, i, columns)
        if run.rival is not None and of_instrument[i] > -after.settings.selection.confounded_margin:
            rivals_too = (*found[-1].confounded_with, *errors_of_instrument_in(run.rival))
            found[-1] = replace(found[-1], confounded_with=rivals_too)
        error_before = errors[1]
    return repeated_changes_doubted(found, after.settings.naming.least_confidence)


def _compared_with_sets(found: Finding, scored: FittedState, i: int, columns: CandidateColumns) -> Finding:
    """Return a finding with at most the confidence that the nearest set of other effects leaves; the first effect of a set that
    explains about as much is confounded with it.

    Args:
        found: The finding for effect i.
        scored: The state with the priors for whitened rows.
        i: Index of the effect.
        columns: The named candidates' columns at ``scored``.
    """
    least = scored.settings.naming.least_confidence
    undecided = found.confidence >= least and found.grounds.log_odds <= CLEAR_ODDS
    if found.doubtful or is_shrunk(scored.effects[i]) or not undecided:
        return found
    nearest = nearest_set(scored, i, columns)
    if nearest is None:
        return found
    limited, instead = found.limited(nearest.probability, least, _LIMITED_BY_SETS), nearest.effects[0]
    near = nearest.lead < scored.settings.selection.confounded_margin
    if not near or any(instead.same_place(effect) for effect in found.confounded_with):
        return limited
    return replace(limited, confounded_with=(*found.confounded_with, instead))


def _finding(
    after: FittedState,
    scored: FittedState,
    i: int,
    columns: CandidateColumns,
    given_all: Sequence[Scored],
    folds: Sequence[WithoutFold],
    unnamed: list[float],
    errors: tuple[HeldOutErrors, HeldOutErrors],
    final_residuals: FinalResiduals,
) -> Finding:
    """Return the finding for effect i of a state, from a comparison with all candidates that might explain the data in its place.

    Args:
        after: The state with all effects.
        scored: The same state with the priors for whitened rows.
        i: Index of the effect.
        columns: The candidates' columns at ``scored``.
        given_all: The scores of the candidates that explain something given all effects of the state. What they explain so does not speak against
            effect i.
        folds: What ``without_each_fold`` returns for ``scored``.
        unnamed: Log evidence [nats] of flexible terms in the effect's place.
        errors: Held-out errors without and with the effect.
        final_residuals: What the residuals of ``after`` show.
    """
    effect, least = after.effects[i], after.settings.naming.least_confidence
    own, ranking = _scores_in_place(scored, i, columns, given_all)
    ranking = with_fitted_rivals(scored, i, own, ranking)
    confounded, weight = _confounded_and_weight(scored, i, own, ranking)
    against = _Against.of(scored, i, own, ranking, unnamed, given_all, folds)
    grounds = against.grounds(against.rivals, final_residuals)
    own_confidence = min(confidence(grounds, effect.name), weight)
    if untried := effect.alike_at_few_positions(after.dataset):
        confounded += untried
        own_confidence = min(own_confidence, 1.0 / (1 + len(untried)))
    # A report lists the confounded effects together with the name. The name is therefore doubtful only if the confidence that the cause is the effect
    # or one of these is too low. This confidence in the whole group is computed against the rivals outside the group.
    outside = [s for s in against.rivals if not any(s.effect.same_place(like) for like in confounded)]
    of_group = confidence(against.grounds(outside, final_residuals), effect.name)
    likely = max(own_confidence, of_group) >= least
    # An effect that moves something against its load describes the structure that is there, but its cause cannot act so. The name could be right only
    # if the coefficient had its sign by chance.
    if effect.against_its_load(after.dataset.robot, after.dataset.known_poses):
        own_confidence, likely = min(own_confidence, own.p_value), False
    return Finding(
        effect,
        own.p_value,
        *errors,
        tuple(confounded),
        own_confidence,
        (),
        grounds,
        doubtful=not (effect.flexible or likely),
    )


def _scores_in_place(
    scored: FittedState, i: int, columns: CandidateColumns, given_all: Sequence[Scored]
) -> tuple[Scored, list[Scored]]:
    """Return the score of effect i given the other effects, and the scores of all candidates in its place, the one with the most evidence first."""
    own, in_its_place = rivals(scored, i, columns)
    if not is_shrunk(scored.effects[i]):
        in_its_place = [*in_its_place, *rivals_of_strongest_part(scored, i, own, columns)]
    ranking = [_in_place_alone(s, given_all) for s in in_its_place]
    ranking.sort(key=lambda s: -s.evidence)
    return own, [s for s in ranking if not has_all_orders(scored, s.effect)]


def _confounded_and_weight(
    scored: FittedState, i: int, own: Scored, ranking: Sequence[Scored]
) -> tuple[list[Effect], float]:
    """Return the effects that are confounded with effect i, and the probability of effect i among the effects that are like it.

    There are none, and the probability is 1, for a flexible term and for all orders of a joint, whose evidence cannot be compared.

    Args:
        scored: The state with the priors for whitened rows.
        i: Index of the effect.
        own: Its score.
        ranking: The scores of the candidates in its place, best first.
    """
    effect = scored.effects[i]
    if effect.flexible or is_shrunk(effect):
        return [], 1.0
    compared = compared_by_akaike(own, ranking, background_without(scored, [i])[0])
    weight = min(akaike_weight(own, compared), _weight_among_alike(own, compared))
    return _confounded(own, compared, scored.settings), weight


@dataclass(frozen=True, eq=False)
class _Against:
    """What speaks against effect i of a state.

    Attributes:
        scored: The state with the priors for whitened rows.
        i: Index of the effect.
        own: Its score.
        rivals: The scores of the candidates in its place that would be other answers, best first.
        unnamed: Log evidence [nats] of flexible terms in its place.
        least_alone: Least log odds of the effect against no effect when one fold of the poses is left out [nats].
        least_odds: Some of the rivals, each with the least of such log odds of the effect against it [nats].
    """

    scored: FittedState
    i: int
    own: Scored
    rivals: Sequence[Scored]
    unnamed: Sequence[float]
    least_alone: float
    least_odds: Sequence[tuple[Scored, float]]

    @classmethod
    def of(
        cls,
        scored: FittedState,
        i: int,
        own: Scored,
        ranking: Sequence[Scored],
        unnamed: Sequence[float],
        given_all: Sequence[Scored],
        folds: Sequence[WithoutFold],
    ) -> _Against:
        """Return what speaks against effect i. An effect with all orders of a joint has no rivals, because its evidence cannot be compared.

        Only the nearest rivals are compared again without each fold. A rival of the effect's strongest part alone cannot be compared so, and its odds
        with all poses count.
        """
        effect = scored.effects[i]
        if is_shrunk(effect):
            ranking, unnamed = [], []
        others = [s for s in ranking if not s.effect.same_answer(effect)]
        nearest = [s for s in others if s.other_parts is None][:NEAREST_RIVALS]
        alone, *odds_by_rival = fold_odds(i, [s.effect for s in nearest], folds).tolist()
        least_odds = [
            (s, odds + _evidence_given_all(s, given_all))
            for s, odds in zip(nearest, odds_by_rival, strict=True)
        ]
        least_odds += [(s, own.evidence - s.evidence) for s in others if s.other_parts is not None]
        return cls(scored, i, own, others, unnamed, alone, least_odds)

    def grounds(self, rivals: Sequence[Scored], final_residuals: FinalResiduals) -> Grounds:
        """Return the grounds of the effect if only some of its rivals are considered.

        Args:
            rivals: Some of the attribute ``rivals``, the same objects.
            final_residuals: What the residuals of the final model show.
        """
        considered = {id(s) for s in rivals}  # comparing all their fields would take long
        least = min([self.least_alone, *(odds for s, odds in self.least_odds if id(s) in considered)])
        evidence = [*(s.evidence for s in rivals), *self.unnamed]
        return grounds_of_effect(self.scored, self.i, self.own, evidence, least, final_residuals)


def _scores_given_all(state: FittedState, columns: CandidateColumns) -> list[Scored]:
    """Return the scores of the candidates that explain something given all effects of a state."""
    return [s for s in rank(state, state.background(), columns) if s.evidence > 0]


def _in_place_alone(entry: Scored, given_all: Sequence[Scored]) -> Scored:
    """Return the score of a candidate in an effect's place, less the log evidence that it has given the effect.

    Let E be log evidence, A the effect and R a rival. Whether A is needed where R acts is E(A and R) - E(R), which is E(A) - (E(R) - E(R given A)).
    """
    more = _evidence_given_all(entry, given_all)
    return replace(entry, evidence=entry.evidence - more) if more else entry


def _evidence_given_all(entry: Scored, given_all: Sequence[Scored]) -> float:
    """Return the log evidence [nats] that a candidate has given all effects of the state; zero if it then explains nothing."""
    return max((s.evidence for s in given_all if s.effect.same_place(entry.effect)), default=0.0)


def _weight_among_alike(own: Scored, ranking: Sequence[Scored]) -> float:
    """Return the probability of an effect among those of its own kind and number of coefficients at other places, if each is as likely beforehand."""

    def alike(s: Scored) -> bool:
        same_kind = s.effect.name == own.effect.name and s.dof == own.dof
        return same_kind and s.other_parts is None and not s.effect.same_place(own.effect)

    return weight_among(own, filter(alike, ranking))


def _confounded(own: Scored, ranking: Sequence[Scored], settings: Settings) -> list[Effect]:
    """Return the effects that explain about as much as an effect does, best first; those with the same name and target are listed once.

    Args:
        own: The score of the effect.
        ranking: The scores of the candidates, best first.
        settings: Thresholds.
    """
    least = own.evidence - settings.selection.confounded_margin
    near = [s.effect for s in ranking if s.evidence > least and not s.effect.same_place(own.effect)]
    answers = [name_and_target(effect) for effect in near]
    return [effect for k, effect in enumerate(near) if answers[k] not in answers[:k]]
