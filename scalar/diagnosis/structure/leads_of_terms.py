"""By how much more log evidence a flexible term has than the named effects in whose place it would stand: a group of effects, or a single one."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np

from scalar.diagnosis.fit.fitted_state import FittedState
from scalar.diagnosis.scoring.candidate_columns import CandidateSet
from scalar.diagnosis.scoring.conditional_scores import background_without, score_together
from scalar.diagnosis.scoring.score_test import evidence
from scalar.diagnosis.structure.ranked_terms import imitating, ranked_once, refined_once
from scalar.diagnosis.structure.replaced_names import groups


def leads_of_terms(state: FittedState, pools: Sequence[CandidateSet]) -> list[float]:
    """Return for each effect the log evidence [nats] by which one flexible term leads it, or the group of effects to which it belongs.

    It is -inf for an effect that is in no group and has no imitators that are as likely beforehand (``Effect.imitators_are_as_likely``).

    Each effect of a group may be better than any term in its place, while the group as a whole imitates one: a scale error and a harmonic of a joint,
    for example, imitate a spring that pushes on a part of the joint's range. The log evidence already penalises the additional coefficients of such
    a term, so that true effects clearly have more evidence than it; no further margin is subtracted.

    Args:
        state: The fitted state.
        pools: The candidate sets of the flexible terms; empty if they were not tried.
    """
    found = [-np.inf] * len(state.effects)
    for indices in groups(state.effects) if pools else ():
        if len(indices) == 1 or any(state.effects[i].flexible for i in indices):
            continue
        left = background_without(state, indices)
        own = score_together(state, indices, pools[0], left)
        entries = ranked_once(state, [left[0]], pools)[0] + [
            entry for i in indices for entry in imitating(state, left[0], state.effects[i])
        ]
        terms = [refined_once(state, left[0], entry) for entry in entries]
        best = max((term.evidence for term in terms), default=-np.inf)
        for i in indices:
            found[i] = max(found[i], float(best - own.evidence))
    for i, effect in enumerate(state.effects):
        if pools and effect.imitators_are_as_likely:
            found[i] = max(found[i], _lead_of_imitators(state, i, pools[0]))
    return found


def _lead_of_imitators(state: FittedState, i: int, pool: CandidateSet) -> float:
    """Return the log evidence [nats] by which what may imitate effect i leads it; -inf if nothing may.

    The place was chosen for both, unless a flexible term varies with the same joint: then the effect does not have the form of the cause, and its
    choice counts against it. That a term is the best of several forms of one cause counts against the term.
    """
    effect, left = state.effects[i], background_without(state, [i])
    own = score_together(state, [i], pool, left)
    term_of_joint = any(e.flexible and f"q{effect.erring_joint}" in e.depends_on for e in state.effects)
    free = float(evidence(left[0], np.array(own.gain), np.array(own.dof), np.array(0.0)))
    terms = effect.imitators(state.dataset)
    forms = Counter(map(type, terms))
    nats = [
        s.evidence + np.log(len(terms) / forms[type(s.effect)]) for s in imitating(state, left[0], effect)
    ]
    return float(max(nats, default=-np.inf)) - (own.evidence if term_of_joint else free)
