"""Joints that err in many orders: all orders are fitted at once, shrunk to the sizes that the data support.

Few poses, or poses over a part of a turn only, do not distinguish neighbouring orders. If orders are chosen one by one, chance decides which, and the
correction at angles that were not measured is noise. Here every order from 1 to 64 is fitted, and shrunk towards zero by a prior. The prior standard
deviation is the same for all orders of a band and for all these joints, and is found by maximising the evidence (MacKay, Bayesian interpolation,
Neural Computation 4, 1992). For angles that were not measured, these standard deviations are too large. They are therefore multiplied by the factor
that best predicts poses in parts of a joint's range that were left out of the fit. Away from the measured angles the correction then tends to zero,
so that it can be used in another campaign.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from scalar.diagnosis.fit.fitted_state import FittedState, whitened
from scalar.diagnosis.held_out.hold_out import held_out_errors, improvement, no_worse
from scalar.diagnosis.scoring.candidate_columns import CandidateColumns, CandidateSet
from scalar.diagnosis.scoring.conditional_scores import rivals
from scalar.diagnosis.scoring.merging import merged
from scalar.diagnosis.scoring.ranking import rank
from scalar.effects import Effect, registry
from scalar.effects.series import Series
from scalar.geometry.se3 import Array

# First and last order of each band with one prior.
BANDS = ((1, 2), (3, 6), (7, 12), (13, 20), (21, 32), (33, 48), (49, 64))
# Prior standard deviation [rad] with which the search starts; the result does not depend on it.
FIRST_SIZE = 3e-5
LEAST_SIZE = 1e-7  # rad: smallest prior standard deviation, 0.1 micrometres at a metre; it shrinks a band to almost nothing
ROUNDS = 60  # most rounds of that search; it usually converges before
CONVERGED = 1e-3  # relative change of the standard deviations that ends it: far below their uncertainty
_RIDGE = 1e-8  # prior weight of all other columns, of unit length, because without a part of the poses some of them may be undetermined
# Factors that are tried on the prior standard deviations of greatest evidence.
PRIOR_SHARES = (1.0, 0.5, 0.25, 0.125)


def with_spectrum(state: FittedState, named: CandidateSet) -> FittedState:
    """Return a state in which joints that err in many orders have all orders, unless held-out poses are then predicted no better.

    The state is returned unchanged as well if no joint has ``settings.spectrum.many_orders`` orders, or if the data are too few for all orders.

    Args:
        state: The state with the orders that were found one by one.
        named: The candidate set of named effects.
    """
    series = _series(state)
    joints = list(series)
    dense = [kind(joint, kind.every_order) for joint, kinds in series.items() for kind in kinds]
    rows = state.dataset.n_poses * state.residuals.measurement.equations_per_pose
    if not joints or rows < state.settings.spectrum.rows_per_column * sum(
        len(effect.coefficients) for effect in dense
    ):
        return state
    sizes, variance = _best_sizes(state, dense, joints)
    std = dict(zip(BANDS, sizes, strict=True))
    kept = [effect for effect in state.effects if not _is_series_of(effect, joints)]
    smooth = [effect.with_term_std([std[_band(order)] for order in effect.orders]) for effect in dense]
    # Fits weigh rows by the stated noise, so priors are scaled by the residual that will remain with all orders.
    misfit = np.sqrt(variance) * _std_ratio(state)
    effects = with_scaled_priors([*smooth, *kept], 1.0 / max(misfit, 1.0))
    trial = state.refitted(effects)
    trial = _with_more(_without_insignificant_series(trial, named), named)
    return trial if improvement(held_out_errors(state), held_out_errors(trial)) > 0 else state


def _best_sizes(state: FittedState, dense: Sequence[Series], joints: Sequence[int]) -> tuple[Array, float]:
    """Return the prior standard deviations ``(len(BANDS),)`` [rad] that predict angles left out best, and the variance of the residual before.

    Args:
        state: The state with the orders that were found one by one.
        dense: All orders of each of the joints.
        joints: The joints, from 1.
    """
    system = LinearSystem.of(state, dense)
    sizes, variance = system.sizes_of_greatest_evidence()
    share = min(PRIOR_SHARES, key=lambda share: system.unseen_error(share * sizes, state, joints))
    return share * sizes, variance


def _without_insignificant_series(state: FittedState, named: CandidateSet) -> FittedState:
    """Return the state without series of all orders of a joint that are not significant, except those without which predictions are worse.

    The series are tried one after the other, the least significant first. Several may matter together although none of them is significant.
    """
    scored = priors_for_whitened_rows(state)
    columns = CandidateColumns.of(scored, named)
    p_values = {
        i: rivals(scored, i, columns)[0].p_value
        for i, effect in enumerate(state.effects)
        if is_shrunk(effect)
    }
    # Refits no longer need these; with many orders and thousands of poses they are the largest arrays of all.
    del scored, columns
    insignificant = [
        state.effects[i]
        for i in sorted(p_values, key=lambda i: -p_values[i])
        if p_values[i] > state.settings.selection.alpha_named_effect
    ]
    for series in insignificant:
        without = state.refitted([effect for effect in state.effects if not effect.same_place(series)])
        if no_worse(held_out_errors(state), held_out_errors(without)):
            state = without
    return state


def _with_more(state: FittedState, named: CandidateSet) -> FittedState:
    """Return a state with further named effects that are significant only given all orders, each confirmed by held-out poses.

    Over a part of a turn, for example, low orders of a joint resemble its deflection by a weight. If orders are chosen one by one, they are chosen
    first, and the deflection then explains nothing more.
    """
    rest = CandidateSet.of([c for c, _ in named.tried if not isinstance(c, Series)])
    for _ in range(state.settings.selection.max_effects):
        scored = priors_for_whitened_rows(state)
        ranking = rank(scored, scored.background(), CandidateColumns.of(scored, rest))
        for entry in ranking[: state.settings.selection.most_candidates_tried]:
            if entry.p_value > state.settings.selection.alpha_named_effect or entry.evidence <= 0:
                return state
            trial = state.refitted(merged(state.effects, entry.effect))
            before, after = held_out_errors(state), held_out_errors(trial)
            gain = improvement(before, after)
            clearly = trial.is_plausible and gain >= state.settings.selection.least_improvement
            if clearly and no_worse(before, after):
                state = trial
                break
        else:
            return state
    return state


def with_scaled_priors(effects: Sequence[Effect], factor: float) -> tuple[Effect, ...]:
    """Return effects with the prior standard deviations of their orders multiplied by a factor; effects without such priors are unchanged."""
    return tuple(
        effect.with_term_std([factor * std for std in effect.term_std])
        if isinstance(effect, Series) and effect.term_std
        else effect
        for effect in effects
    )


def priors_for_whitened_rows(state: FittedState) -> FittedState:
    """Return a state with the priors of its orders scaled for rows that are whitened for its variance component as well.

    Refits use rows whitened for the noise within scans alone, and their priors are scaled for these. Scores and final fits use the other rows.
    """
    if not any(is_shrunk(effect) for effect in state.effects):
        return state
    effects = with_scaled_priors(state.effects, max(_std_ratio(state), 1.0))
    return replace(state, model=replace(state.model, effects=effects))


def has_all_orders(state: FittedState, effect: Effect) -> bool:
    """Return whether an effect consists of orders of a joint that already has all orders, each with its own prior."""
    return isinstance(effect, Series) and any(
        isinstance(own, Series) and own.term_std and own.joint == effect.joint for own in state.effects
    )


def is_shrunk(effect: Effect) -> bool:
    """Return whether an effect has all orders of a joint, each with its own prior; its evidence, which counts columns, cannot be compared."""
    return isinstance(effect, Series) and bool(effect.term_std)


def _std_ratio(state: FittedState) -> float:
    """Return the residual's standard deviation, whitened for the noise within scans alone, over that if it is whitened for whole poses as well."""
    plain = state.background_within_scans()
    return float(np.sqrt(plain.variance / state.background().variance))


def _series(state: FittedState) -> dict[int, list[type[Series]]]:
    """Return the joints whose error is a series, each with the kinds of series that have its orders; none if no joint has many orders."""
    found = [e for e in state.effects if isinstance(e, Series)]
    counts = {joint: 0 for joint in sorted({effect.joint for effect in found})}
    for effect in found:
        counts[effect.joint] += len(effect.orders)
    if max(counts.values(), default=0) < state.settings.spectrum.many_orders:
        return {}
    kinds = [kind for kind in registry.known().values() if issubclass(kind, Series)]
    first = {joint: type(next(e for e in found if e.joint == joint)) for joint in counts}
    return {
        joint: [kind for kind in kinds if issubclass(kind, own) or issubclass(own, kind)]
        for joint, own in first.items()
    }


def _is_series_of(effect: Effect, joints: list[int]) -> bool:
    """Return whether an effect is a series of one of some joints."""
    return isinstance(effect, Series) and effect.joint in joints


def _band(order: int) -> tuple[int, int]:
    """Return the band of an order."""
    return next(band for band in BANDS if band[0] <= order <= band[1])


@dataclass(frozen=True, eq=False)
class LinearSystem:
    """The R whitened rows of a state, linear in the coefficients of all orders and in all other free parameters.

    Attributes:
        A: ``(R, F)``, derivatives by the other free parameters, scaled to columns of unit length.
        E: ``(R, e)``, derivatives by the coefficients of all orders [1/rad].
        residual: ``(R,)``, extrapolated linearly to a model without the orders that were found one by one.
        band: ``(e,)``, index of the band that each column of E belongs to.
    """

    A: Array
    E: Array
    residual: Array
    band: Array

    @classmethod
    def of(cls, state: FittedState, dense: Sequence[Series]) -> LinearSystem:
        """Return the system of a state, whitened for the variance component of whole poses."""
        residual, J = (whitened(state.whitening, rows) for rows in state.linearised())
        joints = [effect.joint for effect in dense]
        mine = np.zeros(len(state.free), dtype=bool)
        start = state.model.blocks["effects"].start
        for effect in state.effects:
            stop = start + len(effect.coefficients)
            mine[start:stop] = _is_series_of(effect, joints)
            start = stop
        local = mine[state.free]
        c = state.model.vector[state.free & mine]
        n = state.dataset.n_poses * state.residuals.measurement.rows_per_pose
        others = J[:n, ~local]
        norms = np.linalg.norm(others, axis=0)
        band = [BANDS.index(_band(order)) for effect in dense for order in effect.orders for _ in range(2)]
        A = others / np.where(norms > 0, norms, 1.0)
        return cls(
            A,
            state.columns_of(dense),
            residual[:n] - J[:n, local] @ c,
            np.array(band),
        )

    def sizes_of_greatest_evidence(self) -> tuple[Array, float]:
        """Return the prior standard deviations ``(len(BANDS),)`` [rad] of greatest evidence, and the variance of the residual with them.

        The other parameters have no prior.
        """
        Q = np.linalg.qr(self.A)[0]
        E = self.E - Q @ (Q.T @ self.E)
        r = self.residual - Q @ (Q.T @ self.residual)
        G, b, sum_of_squares = E.T @ E, -(E.T @ r), float(r @ r)
        n = len(r) - self.A.shape[1]
        sizes, variance = np.full(len(BANDS), FIRST_SIZE), sum_of_squares / n
        for _ in range(ROUNDS):
            s = sizes[self.band]
            inverse = np.linalg.inv(s[:, None] * G * s / variance + np.eye(len(s)))
            c = s * (inverse @ (s * b)) / variance
            known = np.bincount(self.band, 1.0 - np.diag(inverse), len(BANDS))
            power = np.bincount(self.band, c * c, len(BANDS))
            rest = sum_of_squares - 2.0 * float(c @ b) + float(c @ G @ c)
            variance = rest / max(n - float(known.sum()), 1.0)
            new = np.maximum(np.sqrt(power / np.maximum(known, 1e-9)), LEAST_SIZE)
            done = np.max(np.abs(np.log(new / sizes))) < CONVERGED
            sizes = new
            if done:
                break
        return sizes, variance

    def unseen_error(self, sizes: Array, state: FittedState, joints: Sequence[int]) -> float:
        """Return the squared error at poses in parts of the joints' ranges, each part predicted by a fit without it.

        Args:
            sizes: ``(len(BANDS),)`` [rad], prior standard deviations.
            state: The state of these rows.
            joints: The joints, from 1; the parts of each joint's range are left out in turn.
        """
        X = np.concatenate([self.A, self.E * sizes[self.band]], axis=1)
        ridge = np.r_[np.full(self.A.shape[1], _RIDGE), np.ones(self.E.shape[1])]
        gram, projection = X.T @ X + np.diag(ridge), X.T @ self.residual
        m, parts = state.residuals.measurement.rows_per_pose, state.settings.hold_out.folds
        total = 0.0
        for joint in joints:
            q = state.dataset.q[:, joint - 1]
            part = np.searchsorted(np.quantile(q, np.linspace(0, 1, parts + 1)[1:-1]), q)
            for k in range(parts):
                out = np.repeat(part == k, m)
                left = X[out]
                c = -np.linalg.solve(gram - left.T @ left, projection - left.T @ self.residual[out])
                total += float(np.sum((self.residual[out] + left @ c) ** 2))
        return total
