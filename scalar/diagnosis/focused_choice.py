"""Choose which effects the shipped model contains: those with which predictions at other poses are expected to have the smallest error.

An effect may be significant although its correction does harm. An error of the scanner over its range, for example, is almost equivalent to a
change of the arm's lengths, and if its assumed form is wrong, it biases them. The focused information criterion (Claeskens and Hjort, Journal of
the American Statistical Association 98, 2003) estimates the mean squared error of a quantity, here of predicted positions at random poses, for
every model nested in a wide one. This mean squared error is the sum of the variance and the squared bias. The squared bias is estimated by the
squared difference from the wide model's prediction, less the squared difference that is expected by chance alone. Here the latter is multiplied by
``settings.shipped_fit.beyond_chance`` squared before it is subtracted, because a correction that does harm is worse than one that is missing. The
variances are those of the jackknife over poses (``jackknife``), which is valid for any noise within a pose.

The wide model contains all effects that were found. If one of them is a special case of a more general effect, the wide model contains that effect as
well; the general effect is never shipped and only shows the bias of the others. The wide model also contains deviations that every set-up has to a
small degree (``Effect.nuisances``): for example, no target plane is perfectly flat. These may be shipped too, although they are no findings: if one
target plane is bowed, for example, the arm is estimated more accurately if the smaller bows of the other planes are fitted as well. A nuisance is
shipped only if it is significant in the wide model. The expected errors alone do not show that it is not there: it is then fitted to the noise, and
the squared bias that it seems to remove has an error of its own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

from scalar.diagnosis.fitted_state import FittedState, plausibly_refitted
from scalar.diagnosis.jackknife import Linearised, covariance_of, variance_of
from scalar.effects import Effect
from scalar.effects.registry import known
from scalar.estimation.displacement import position_std, position_variance
from scalar.geometry.se3 import Array
from scalar.units import MM

Errors = tuple[float, float, float]
"""Expected errors of a predicted position [m]: within the joint limits, within the measured ranges, at the measured poses."""
LIMITS, RANGES, MEASURED = 0, 1, 2  # the indices of ``Errors``
LATE = 0.1  # chosen: of the poses; a change that fewer of them show may as well be a few poses that err


@dataclass(frozen=True, eq=False)
class FocusedChoice:
    """The effects that the shipped model contains, and the errors that are expected of its predictions.

    Attributes:
        state: The fit with the effects that were chosen.
        left_out: Effects that were found and are not in this fit.
        added: Effects that were not found and are in this fit.
        error_with_all: Expected error of a predicted position [m] with all effects, root mean square over poses within the joint limits.
        errors_as_chosen: Expected errors with the effects that were chosen.
        errors_without: Expected errors without effects.
        std_without: Standard error of a predicted position [m] without effects, root mean square over poses within the joint limits.
    """

    state: FittedState
    left_out: tuple[Effect, ...]
    added: tuple[Effect, ...]
    error_with_all: float
    errors_as_chosen: Errors
    errors_without: Errors
    std_without: float

    @property
    def as_found(self) -> bool:
        """Return whether the model contains the effects that were found, and no others."""
        return not self.left_out and not self.added

    def expected_errors(self, *, without_effects: bool) -> Errors:
        """Return the expected errors of the model without effects, or of the fit with the effects that were chosen."""
        return self.errors_without if without_effects else self.errors_as_chosen

    def to_mapping(self, *, without_effects: bool) -> dict[str, object]:
        """Return the choice as it stands in ``diagnosis.json``.

        Args:
            without_effects: Whether the model without effects is shipped.
        """
        expected = self.expected_errors(without_effects=without_effects)
        return {
            "left_out": [{"name": effect.name, "target": effect.target} for effect in self.left_out],
            "added": [{"name": effect.name, "target": effect.target} for effect in self.added],
            "expected_error_mm": {
                "with_all": self.error_with_all / MM,
                "as_shipped": expected[LIMITS] / MM,
                "as_shipped_within_measured_ranges": expected[RANGES] / MM,
            },
        }


def focused_choice(after: FittedState, unsure: Sequence[str] = ()) -> FocusedChoice:
    """Return the effects with which predictions are expected to err least.

    Effects are left out one after the other as long as the expected error falls; in each step the one is left out without which the error is
    smallest. This is done twice: from the effects that were found, and from these together with the significant nuisances. The better of the two
    results is chosen if two conditions hold: its error within the joint limits is clearly smaller than with all effects that were found
    (``settings.shipped_fit.clearly_smaller_error``), and its errors are no larger within the measured ranges of the joints and at the measured poses.
    Else all effects that were found are kept. The second condition keeps a correction that is uncertain only where nothing was measured. The ranges
    alone are not enough for it: poses that press a tool on target planes, for example, fill a small part of the ranges, and predictions for the rest
    are not determined.

    A change that begins among the last few poses (``LATE``) and has no sure name is not shipped: it would be applied to every later pose.

    Finally, no effect is shipped if the error remains above ``settings.shipped_fit.worth_correcting`` times that of the model without effects, both
    within the joint limits and at the measured poses.

    Args:
        after: The state with all effects that were found.
        unsure: Keys of those among them whose names are doubtful. Flexible terms have no name.
    """
    effects = after.effects
    if not effects:
        alone = NestedModels(after)
        errors = alone.errors(())
        return FocusedChoice(after, (), (), errors[LIMITS], errors, errors, alone.std(()))
    settings = after.settings.shipped_fit
    nuisances, general = _nuisances(after), _general(after)
    everything = (*effects, *nuisances, *general)
    wide = NestedModels(after.refitted(everything, after.model) if len(everything) > len(effects) else after)
    found = tuple(range(len(effects)))
    with_all = wide.errors(found)
    significant = [
        i
        for i in range(len(effects), len(effects) + len(nuisances))
        if wide.p_value(i) <= after.settings.selection.alpha_named_effect
    ]
    starts = {found, (*found, *significant)}
    kept = min(
        (_eliminated(wide, start, with_all) for start in sorted(starts)),
        key=lambda kept: wide.errors(kept)[LIMITS],
    )
    errors, without = wide.errors(kept), wide.errors(())
    if errors[LIMITS] > settings.clearly_smaller_error * with_all[LIMITS] or not _no_worse(errors, with_all):
        kept, errors = found, with_all
    if all(errors[k] > settings.worth_correcting * without[k] for k in (LIMITS, MEASURED)):
        kept, errors = (), without
    late = [i for i in kept if i < len(effects) and _is_late(effects[i], after, unsure)]
    if late:
        kept = tuple(i for i in kept if i not in late)
        errors = wide.errors(kept)
    chosen = after if kept == found else plausibly_refitted(after, [everything[i] for i in kept])
    # The comparison above is linear about the optimum with all effects, and a refit may end elsewhere.
    if chosen is after:
        kept, errors = found, with_all
    return FocusedChoice(
        chosen,
        tuple(effects[i] for i in found if i not in kept),
        tuple(everything[i] for i in kept if i not in found),
        with_all[LIMITS],
        errors,
        without,
        wide.std(()),
    )


def _is_late(effect: Effect, after: FittedState, unsure: Sequence[str]) -> bool:
    """Return whether an effect is a change without a sure name that begins among the last few poses."""
    if not (effect.flexible or effect.key in unsure):
        return False
    since = effect.since(after.residuals.poses)
    return since is not None and float(np.mean(since)) < LATE


def _nuisances(after: FittedState) -> list[Effect]:
    """Return the effects that every set-up has to a small degree (``Effect.nuisances``), without those that were found."""
    possible = [effect for kind in known().values() for effect in kind.nuisances(after.dataset)]
    return _not_found(after, possible)


def _general(after: FittedState) -> list[Effect]:
    """Return a list of at most one effect of which a found effect is a special case; several general effects would be almost equivalent."""
    general = (effect.generalised(after.dataset) for effect in after.effects)
    return _not_found(after, [effect for effect in general if effect is not None])[:1]


def _not_found(after: FittedState, effects: list[Effect]) -> list[Effect]:
    """Return those of ``effects`` that act at no place at which an effect was found."""
    return [effect for effect in effects if not any(effect.same_place(other) for other in after.effects)]


def _eliminated(wide: NestedModels, kept: tuple[int, ...], most: Errors) -> tuple[int, ...]:
    """Return the indices of the effects that remain after backward elimination by the expected error within the joint limits.

    Elimination ends when leaving out any further effect would raise the error within the joint limits, or give errors larger than those of ``most``
    within the measured ranges or at the measured poses.

    Args:
        wide: The wide model and the models nested in it.
        kept: Indices of the effects of the wide model to start from.
        most: Errors that may not be exceeded within the measured ranges and at the measured poses.
    """
    least = wide.errors(kept)[LIMITS]
    while kept:
        fewer = [tuple(k for k in kept if k != i) for i in kept]
        errors = [wide.errors(indices) for indices in fewer]
        allowed = [each[LIMITS] if _no_worse(each, most) else np.inf for each in errors]
        best = int(np.argmin(allowed))
        if allowed[best] >= least:
            break
        kept, least = fewer[best], allowed[best]
    return kept


def _no_worse(errors: Errors, reference: Errors) -> bool:
    """Return whether ``errors`` are no larger than those of ``reference``, both within the measured ranges and at the measured poses."""
    return all(errors[k] <= reference[k] for k in (RANGES, MEASURED))


class NestedModels:
    """A wide model, linearised at its optimum, and the models nested in it, which have some of its effects.

    Attributes:
        linear: The linearised fit, with F free coordinates.
        beyond_chance: Standard errors up to which a difference of predictions counts as chance.
        effect_index: ``(F,)``, index of the effect that each free coordinate belongs to; -1 for robot, sensor and target.
        optimum: Step to the optimum of the wide model and the steps without each pose, as ``Linearised.fitted`` returns them.
    """

    def __init__(self, state: FittedState):
        """Linearise a state that has all effects of the wide model."""
        self.linear = Linearised(state, None)
        self.beyond_chance = state.settings.shipped_fit.beyond_chance
        sizes = [len(effect.coefficients) for effect in state.effects]
        effect_index = np.r_[np.full(len(state.geometry_free), -1), np.repeat(np.arange(len(sizes)), sizes)]
        self.effect_index = effect_index[state.free]
        self.optimum = self.linear.fitted(np.ones(len(self.effect_index), dtype=bool))

    def errors(self, kept: tuple[int, ...]) -> Errors:
        """Return the expected errors [m] of a predicted position, root mean square over poses, with the effects of the indices ``kept``.

        The first is over random poses within the joint limits, the second over random poses within the measured ranges, the third over measured
        poses.
        """
        linear, free = self.linear, self._free(kept)
        step, left_out = linear.fitted(free)
        covariance = self._covariance(free, left_out)
        within_limits, within_ranges, measured = (
            self._error(step, left_out, covariance, columns)
            for columns in (linear.columns, linear.columns_in_ranges, linear.columns_measured)
        )
        return within_limits, within_ranges, measured

    def std(self, kept: tuple[int, ...]) -> float:
        """Return the standard error [m] of a predicted position, root mean square over poses within the joint limits; arguments as for ``errors``."""
        free = self._free(kept)
        return position_std(self.linear.columns, self._covariance(free, self.linear.fitted(free)[1]))

    def p_value(self, index: int) -> float:
        """Return the probability of coefficients as large as those of an effect in the wide model if all of them were zero (Wald's test).

        Their covariance is that of the jackknife over poses.
        """
        own = self.effect_index == index
        step, left_out = self.optimum
        estimate = (self.linear.coefficients + step)[own]
        covariance = covariance_of(left_out[:, own])
        wald = estimate @ np.linalg.pinv(covariance, hermitian=True) @ estimate
        return float(chi2.sf(wald, len(estimate)))

    def _covariance(self, free: Array, left_out: Array) -> Array:
        """Return the covariance ``(F, F)`` of the coordinates of a nested model: by the jackknife, and by what the data sheet may err.

        Args:
            free: ``(F,)`` bool, the coordinates that the nested model has.
            left_out: ``(N, F)``, the steps from its fit when each of the N poses is left out, as ``Linearised.fitted`` returns them.
        """
        by_data_sheet = self.linear.steps_of_data_sheet(free)
        return covariance_of(left_out) + by_data_sheet.T @ by_data_sheet

    def _free(self, kept: tuple[int, ...]) -> Array:
        """Return which coordinates ``(F,)`` a nested model has."""
        return (self.effect_index < 0) | np.isin(self.effect_index, kept)

    def _error(self, step: Array, left_out: Array, covariance: Array, columns: Array) -> float:
        """Return the expected error [m] at K poses: the root of the variance plus the squared bias beyond chance.

        Args:
            step: ``(F,)``, to the optimum of the nested model.
            left_out: ``(N, F)``, the further steps when each of the N poses is left out of that fit.
            covariance: ``(F, F)``, of the coordinates of the nested model.
            columns: ``(3 K, F)``, derivatives of the positions at K poses [m].
        """
        wide_step, wide_left_out = self.optimum
        difference = columns @ (step - wide_step)
        squared_distance = float(difference @ difference) / (len(difference) / 3)
        by_chance = variance_of(left_out - wide_left_out, columns)
        squared_bias = max(squared_distance - self.beyond_chance**2 * by_chance, 0.0)
        return float(np.sqrt(position_variance(columns, covariance) + squared_bias))
