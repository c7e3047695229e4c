"""Which of the effects that were found the shipped model contains: those with which predictions elsewhere are nearest to the truth.

An effect may be significant and its correction do harm: an error of the scanner over its range is all but a change of the arm's lengths, and a
wrong form of it moves them. The focused information criterion (Claeskens and Hjort, Journal of the American Statistical Association 98, 2003)
estimates the mean squared error of what is asked for, here predicted positions at random poses, for every model within a wide one: its
variance, and the square of its distance to the wide model's prediction, less what chance makes of that distance. Here a multiple of what
chance makes is taken off (``settings.shipped_fit.beyond_chance``, squared), since a correction that does harm is worse than one that is
missing. The variances are those of the jackknife over poses, which hold whatever the noise of a pose is. The wide model has all that was
found and, for an effect of a special form, a more general one beside it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from scalar.diagnosis.fitted_state import FittedState
from scalar.diagnosis.jackknife import Linearised, variance_of
from scalar.effects import Effect
from scalar.geometry.se3 import Array
from scalar.units import MM


@dataclass(frozen=True, eq=False)
class FocusedChoice:
    """The effects that a shipped model contains.

    Attributes:
        state: The model with them.
        left_out: Effects that were found and are not in it.
        error_with, error_without: Expected error of a predicted position [m], root mean square within the joint limits, with all effects found
            and as chosen.
        error_measured: The latter within the ranges of the joints that were measured.
    """

    state: FittedState
    left_out: tuple[Effect, ...]
    error_with: float
    error_without: float
    error_measured: float

    def to_mapping(self) -> dict[str, object]:
        """Return what ``diagnosis.json`` says of it."""
        return {
            "left_out": [{"name": effect.name, "target": effect.target} for effect in self.left_out],
            "expected_error_mm": {
                "with_all": self.error_with / MM,
                "as_shipped": self.error_without / MM,
                "as_shipped_within_measured_ranges": self.error_measured / MM,
            },
        }


def focused_choice(after: FittedState) -> FocusedChoice:
    """Return the effects with which predictions are expected to err least, of those that were found.

    Effects are left out one after the other, that one first without which the expected error is least, as long as it falls; all of them at once
    are tried as well. What is chosen has to be clearly better than the model with all effects within the joint limits
    (``settings.shipped_fit.nearer``), and not worse within the ranges of the joints that were measured, nor at the measured poses: a correction
    that is only uncertain where nobody has measured still serves where somebody has. The ranges alone do not show this. Poses that press a tool
    on plates, say, fill a small part of them, and anything may be predicted for the rest.

    Args:
        after: With all that was found.
    """
    effects = after.effects
    if not effects:
        return FocusedChoice(after, (), 0.0, 0.0, 0.0)
    general = [e.generalised(after.dataset) for e in effects]
    beside = [e for e in general if e is not None and not any(e.same_place(other) for other in effects)]
    wide = _Wide(after.refitted((*effects, *beside[:1]), after.model) if beside else after)
    every = tuple(range(len(effects)))
    with_all, *near_with_all = wide.errors(every)
    kept, least = every, with_all
    while kept:
        fewer = [_without(kept, i) for i in kept]
        errors = [wide.errors(model) for model in fewer]
        allowed = [anywhere if _no_worse(near, near_with_all) else np.inf for anywhere, *near in errors]
        best = int(np.argmin(allowed))
        if allowed[best] >= least:
            break
        kept, least = fewer[best], allowed[best]
    error, *near = wide.errors(())
    if error < least and _no_worse(near, near_with_all):
        kept, least = (), error
    if kept == every or least > after.settings.shipped_fit.nearer * with_all:
        return FocusedChoice(after, (), with_all, with_all, near_with_all[0])
    state = after.refitted([effects[i] for i in kept])
    left_out = tuple(effects[i] for i in every if i not in kept)
    return FocusedChoice(state, left_out, with_all, least, wide.errors(kept)[1])


def _no_worse(errors: list[float], than: list[float]) -> bool:
    return all(error <= other for error, other in zip(errors, than, strict=True))


def _without(kept: tuple[int, ...], i: int) -> tuple[int, ...]:
    return tuple(k for k in kept if k != i)


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

    def errors(self, kept: tuple[int, ...]) -> tuple[float, float, float]:
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
