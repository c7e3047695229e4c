"""Find the changes that explain the difference of two calibrations, by forward selection at a level that holds for all candidates together.

A candidate is one geometric parameter, or all terms of one effect. With y the whitened difference and H_k the response to candidate k,
``y = sum of H_k c_k + noise of unit variance``. Each step adds the candidate that explains most, if the probability that chance makes
any of the m candidates explain as much is below alpha (Bonferroni: m times the chi-squared probability of the reduction). A candidate that
the later ones make needless is removed again. What the chosen candidates leave of y is tested as a whole.

A candidate gives way to one of its rivals, which explain nearly as much, if that is a change of another order of probability: a joint's zero is lost
whenever its motor or its encoder is exchanged, and a length changes only if something is bent.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

from scalar.comparison.invariants import Invariants
from scalar.geometry.se3 import Array

ALPHA = 0.01
"""Probability that two calibrations of an unchanged arm show any change."""
_SAME = 0.9999  # cosine above which two candidates are one
# In chi-squared, a likelihood ratio of 20: a rival that explains less by no more than this is not ruled out.
_RIVAL = 2.0 * np.log(20.0)


@dataclass(frozen=True)
class Candidate:
    """What may have changed: a geometric parameter, or an effect with all its terms.

    Attributes:
        name: Name of the parameter or of the effect.
        columns: Indices of its parameters among those of the arm.
        is_common: Whether it is far more common than the others, as the zero of a joint is.
    """

    name: str
    columns: tuple[int, ...]
    is_common: bool = False


@dataclass(frozen=True, eq=False)
class Change:
    """A change beyond chance.

    Attributes:
        candidate: What changed.
        value, std: ``(k,)``, change of each of its parameters and its standard error, in their units.
        p_value: Probability that chance alone makes any of the candidates explain as much.
        rivals: Candidates that explain nearly as much in its place.
    """

    candidate: Candidate
    value: Array
    std: Array
    p_value: float
    rivals: tuple[Candidate, ...]


def find_changes(
    compared: Invariants, candidates: list[Candidate], alpha: float = ALPHA
) -> tuple[list[Change], float]:
    """Return the changes beyond chance, the surest first, and the p-value of the difference that they leave unexplained.

    Args:
        compared: The whitened difference and responses.
        candidates: What may have changed.
        alpha: Probability of any change being found where there is none.
    """
    y, H = compared.difference, compared.response
    comparable = [c for c in candidates if np.linalg.norm(H[:, list(c.columns)]) > 0]
    distinct = _distinct(H, comparable)
    n_tests = len(distinct)
    chosen: list[Candidate] = []
    while len(chosen) < len(y):
        left = [c for c in distinct if c not in chosen]
        found = [(_p_value(y, H, chosen, c), c) for c in left]
        p, best = min(found, key=lambda f: f[0], default=(1.0, None))
        if best is None or p * n_tests > alpha:
            break
        chosen.append(best)
        kept = [c for c in chosen if _p_value(y, H, [o for o in chosen if o is not c], c) * n_tests <= alpha]
        if best not in kept:
            chosen.remove(best)
            break
        chosen = kept
    for i, candidate in enumerate(chosen):
        chosen[i] = _commoner(y, H, chosen, candidate, comparable)
    changes = [_change(y, H, chosen, c, comparable, n_tests) for c in chosen]
    left_over, rank = _left_over(y, H, chosen)
    rest = float(chi2.sf(left_over, len(y) - rank)) if len(y) > rank else 1.0
    return sorted(changes, key=lambda change: change.p_value), rest


def _columns(H: Array, chosen: list[Candidate]) -> Array:
    """Return the responses to some candidates, each scaled to length 1."""
    index = [i for candidate in chosen for i in candidate.columns]
    columns = H[:, index]
    lengths = np.linalg.norm(columns, axis=0)
    return columns / np.where(lengths > 0, lengths, 1.0)


def _left_over(y: Array, H: Array, chosen: list[Candidate]) -> tuple[float, int]:
    """Return the squared length of the part of y that some candidates leave unexplained, and the rank of their responses."""
    if not chosen:
        return float(y @ y), 0
    basis, values, _ = np.linalg.svd(_columns(H, chosen), full_matrices=False)
    basis = basis[:, values > 1e-6 * values[0]]
    along = basis.T @ y
    return max(float(y @ y - along @ along), 0.0), basis.shape[1]


def _p_value(y: Array, H: Array, given: list[Candidate], candidate: Candidate) -> float:
    """Return the chi-squared probability that chance makes a candidate explain as much as it does, beyond the given ones."""
    before, rank_before = _left_over(y, H, given)
    after, rank = _left_over(y, H, [*given, candidate])
    return float(chi2.sf(before - after, rank - rank_before)) if rank > rank_before else 1.0


def _distinct(H: Array, candidates: list[Candidate]) -> list[Candidate]:
    """Return the candidates without those whose response has the directions of an earlier one's."""
    kept: list[Candidate] = []
    for candidate in candidates:
        if not any(_cosine(H, candidate, other) > _SAME for other in kept):
            kept.append(candidate)
    return kept


def _cosine(H: Array, one: Candidate, other: Candidate) -> float:
    """Return the cosine of the largest angle between the spaces that two candidates' responses span, 0 if their dimensions differ."""
    if len(one.columns) != len(other.columns):
        return 0.0
    bases = [np.linalg.qr(_columns(H, [candidate]))[0] for candidate in (one, other)]
    return float(np.linalg.svd(bases[0].T @ bases[1], compute_uv=False)[-1])


def _change(
    y: Array,
    H: Array,
    chosen: list[Candidate],
    candidate: Candidate,
    comparable: list[Candidate],
    n_tests: int,
) -> Change:
    """Return one of the chosen candidates with its size, estimated together with the others, its p-value and its rivals."""
    index = [i for c in chosen for i in c.columns]
    lengths = np.linalg.norm(H[:, index], axis=0)
    lengths = np.where(lengths > 0, lengths, 1.0)
    inverse = np.linalg.pinv(H[:, index] / lengths)
    values = (inverse @ y) / lengths
    std = np.sqrt(np.sum(inverse**2, axis=1)) / lengths
    own = [index.index(i) for i in candidate.columns]
    others = [c for c in chosen if c is not candidate]
    p = min(_p_value(y, H, others, candidate) * n_tests, 1.0)
    return Change(candidate, values[own], std[own], p, tuple(_rivals(y, H, chosen, candidate, comparable)))


def _rivals(
    y: Array, H: Array, chosen: list[Candidate], candidate: Candidate, comparable: list[Candidate]
) -> dict[Candidate, float]:
    """Return the candidates that explain nearly as much in the place of a chosen one, or more, with what they leave unexplained."""
    others, unexplained = [c for c in chosen if c is not candidate], _left_over(y, H, chosen)[0]
    in_its_place = {c: _left_over(y, H, [*others, c])[0] for c in comparable if c not in chosen}
    return {c: left_over for c, left_over in in_its_place.items() if left_over < unexplained + _RIVAL}


def _commoner(
    y: Array, H: Array, chosen: list[Candidate], candidate: Candidate, comparable: list[Candidate]
) -> Candidate:
    """Return the rival of a chosen candidate that is far more common and explains most; the candidate itself if there is none."""
    if candidate.is_common:
        return candidate
    common = {c: left for c, left in _rivals(y, H, chosen, candidate, comparable).items() if c.is_common}
    return min(common, key=lambda c: common[c], default=candidate)
