"""Choose which of the effects that were found the shipped model contains: those with which predictions at other poses have the smallest error.

An effect may be significant although its correction does harm. An error of the scanner over its range, for example, is almost equivalent to a
change of the arm's lengths, and if its assumed form is wrong, it biases them. The focused information criterion (Claeskens and Hjort, Journal of
the American Statistical Association 98, 2003) estimates the mean squared error of a quantity, here of predicted positions at random poses, for
every model nested in a wide one. It is the sum of the variance and the squared bias; the bias is estimated by the distance to the wide model's
prediction, and the expected square of this distance by chance alone is subtracted. Here a multiple of it is subtracted
(``settings.shipped_fit.beyond_chance``, squared), because a correction that does harm is worse than one that is missing. The variances are those
of the jackknife over poses, which is valid for any noise within a pose.

The wide model contains all effects that were found and, for an effect that is a special case, a more general one as well. It also contains
deviations that every set-up of the kind has to a small degree, since no target plane is perfectly flat (``Effect.nuisances``). These may be
shipped too, although they are no findings: if one target plane is bowed, for example, the arm is estimated more accurately if the smaller bows of
the other planes are fitted as well.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from scalar.diagnosis.fitted_state import FittedState
from scalar.diagnosis.jackknife import Linearised, variance_of
from scalar.effects import Effect
from scalar.effects.registry import known
from scalar.geometry.se3 import Array
from scalar.units import MM

Errors = tuple[float, float, float]
"""Expected errors of a predicted position [m]: within the joint limits, within the measured ranges, at the measured poses."""
LIMITS, RANGES, MEASURED = 0, 1, 2


@dataclass(frozen=True, eq=False)
class FocusedChoice:
    """The effects that a shipped model contains.

    Attributes:
        state: The model with them.
        left_out: Effects that were found and are not in it.
        added: Effects that were not found and are in it.
        error_with_all: Expected error of a predicted position [m] with all effects, root mean square over poses within the joint limits.
        error_as_shipped: The same with the effects that were chosen.
        error_measured: The same with the effects that were chosen, over poses within the measured ranges of the joints.
    """

    state: FittedState
    left_out: tuple[Effect, ...]
    added: tuple[Effect, ...]
    error_with_all: float
    error_as_shipped: float
    error_measured: float

    @property
    def as_found(self) -> bool:
        """Return whether the model contains the effects that were found, and no others."""
        return not self.left_out and not self.added

    def to_mapping(self) -> dict[str, object]:
        """Return what ``diagnosis.json`` says of it."""
        return {
            "left_out": [{"name": effect.name, "target": effect.target} for effect in self.left_out],
            "added": [{"name": effect.name, "target": effect.target} for effect in self.added],
            "expected_error_mm": {
                "with_all": self.error_with_all / MM,
                "as_shipped": self.error_as_shipped / MM,
                "as_shipped_within_measured_ranges": self.error_measured / MM,
            },
        }


def focused_choice(after: FittedState) -> FocusedChoice:
    """Return the effects with which predictions are expected to err least.

    Effects are left out one after the other, that one first without which the expected error is least, as long as it falls: once from those
    that were found, once from all of the wide model. What is chosen has to be clearly better than the model with all that was found within the
    joint limits (``settings.shipped_fit.nearer``), and not worse within the ranges of the joints that were measured, nor at the measured poses:
    a correction that is only uncertain where nobody has measured still serves where somebody has. The ranges alone do not show this. Poses that
    press a tool on plates, say, fill a small part of them, and anything may be predicted for the rest. Nothing is shipped where the model
    without effects errs little more (``settings.shipped_fit.worth_correcting``), neither there nor at the measured poses.

    Args:
        after: With all that was found.
    """
    effects = after.effects
    if not effects:
        return FocusedChoice(after, (), (), 0.0, 0.0, 0.0)
    settings = after.settings.shipped_fit
    nuisances, general = _nuisances(after), _general(after)
    everything = (*effects, *nuisances, *general)
    wide = _Wide(after.refitted(everything, after.model) if len(everything) > len(effects) else after)
    found = tuple(range(len(effects)))
    with_all = wide.errors(found)
    starts = {found, tuple(range(len(effects) + len(nuisances)))}
    kept = min(
        (_fewest(wide, start, with_all) for start in sorted(starts)),
        key=lambda kept: wide.errors(kept)[LIMITS],
    )
    if wide.errors(kept)[LIMITS] > settings.nearer * with_all[LIMITS] or not _no_worse(
        wide.errors(kept), with_all
    ):
        kept = found
    least, without = wide.errors(kept), wide.errors(())
    if all(least[k] > settings.worth_correcting * without[k] for k in (LIMITS, MEASURED)):
        kept = ()
    return FocusedChoice(
        after if kept == found else after.refitted([everything[i] for i in kept]),
        tuple(effects[i] for i in found if i not in kept),
        tuple(everything[i] for i in kept if i not in found),
        with_all[LIMITS],
        wide.errors(kept)[LIMITS],
        wide.errors(kept)[RANGES],
    )


def _nuisances(after: FittedState) -> list[Effect]:
    """Return what any set-up has a little of, and was not found."""
    possible = [effect for kind in known().values() for effect in kind.nuisances(after.dataset)]
    return [effect for effect in possible if not any(effect.same_place(other) for other in after.effects)]


def _general(after: FittedState) -> list[Effect]:
    """Return a more general effect than one that was found, at most one: others would describe the same."""
    general = (effect.generalised(after.dataset) for effect in after.effects)
    beside = (e for e in general if e is not None and not any(e.same_place(other) for other in after.effects))
    return list(beside)[:1]


def _fewest(wide: _Wide, kept: tuple[int, ...], than: Errors) -> tuple[int, ...]:
    """Return which effects are left once leaving out another would add to the expected error, or make it worse at measured poses."""
    least = wide.errors(kept)[LIMITS]
    while kept:
        fewer = [tuple(k for k in kept if k != i) for i in kept]
        errors = [wide.errors(model) for model in fewer]
        allowed = [each[LIMITS] if _no_worse(each, than) else np.inf for each in errors]
        best = int(np.argmin(allowed))
        if allowed[best] >= least:
            break
        kept, least = fewer[best], allowed[best]
    return kept


def _no_worse(errors: Errors, than: Errors) -> bool:
    """Return whether errors are no larger, within the measured ranges and at the measured poses."""
    return all(errors[k] <= than[k] for k in (RANGES, MEASURED))


class _Wide:
    """A wide model, linearised at its optimum, and the models within it: with some of its effects."""

    def __init__(self, state: FittedState):
        """Linearise."""
        self.linear = Linearised(state, None)
        self.beyond_chance = state.settings.shipped_fit.beyond_chance
        # The effect that each free coordinate belongs to, -1 for the geometry.
        sizes = [len(effect.coefficients) for effect in state.effects]
        owner = np.r_[np.full(len(state.geometry_free), -1), np.repeat(np.arange(len(sizes)), sizes)]
        self.owner = owner[state.free]
        self.optimum = self.linear.fitted(np.ones(len(self.owner), dtype=bool))

    def errors(self, kept: tuple[int, ...]) -> Errors:
        """Return the expected error [m] of a predicted position with some of the effects, root mean square over poses.

        The first is that of random poses within the joint limits, the second that within the measured ranges, the third that of measured poses.
        """
        step, left_out = self.linear.fitted((self.owner < 0) | np.isin(self.owner, kept))
        linear = self.linear
        anywhere, in_ranges, measured = (
            self._error(step, left_out, columns)
            for columns in (linear.columns, linear.columns_in_ranges, linear.columns_measured)
        )
        return anywhere, in_ranges, measured

    def _error(self, step: Array, left_out: Array, columns: Array) -> float:
        wide_step, wide_left_out = self.optimum
        apart = columns @ (step - wide_step)
        bias = float(apart @ apart) / (len(apart) / 3)
        by_chance = variance_of(left_out - wide_left_out, columns)
        beyond = max(bias - self.beyond_chance**2 * by_chance, 0.0)
        return float(np.sqrt(variance_of(left_out, columns) + beyond))
