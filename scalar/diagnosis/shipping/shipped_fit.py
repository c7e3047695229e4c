"""Choose which fit is shipped as ``after.json``; all that is reported is computed for that fit.

Where a variance component is identified, the fit may use its weights or equal weights. The weights are used if predictions at poses that were not
measured then vary clearly less when single poses are left out (``jackknife``). Held-out errors do not decide between them: they are distances at
measured poses, each with a random error of its own, and say little about which fit predicts other poses better. There is one exception. If the
predictions of the two fits differ by more than chance allows, the supposed random error is not the same at all poses. The weights are then used only
if they do not predict held-out poses clearly worse either.

The shipped model need not contain exactly the effects that were found: effects whose correction is expected to make predictions elsewhere worse are
left out, and others may be added (``focused_choice``). If the model without effects has smaller errors than the fit with the chosen effects and equal
weights, it is shipped instead, and the effects remain findings, because a correction that does harm is worse than one that is missing. The errors
compared are those of held-out poses, of held-out regions of the joint space (effects may predict poses between measured ones well and yet not
extrapolate), and of unseen poses where they are known. If the effects are expected to reduce the errors to half, the loss at a single block of
held-out poses does not count, unless the whole error grows to twice its size with it. The model without effects is shipped as well if the fit with
effects is expected to err far more within the joint limits than the model without effects errs at held-out poses, unless that model is itself as
uncertain. If only a few joints moved, for example, their effects do not extrapolate to poses of the others.

A test of whether the fits with and without weights differ (Hausman, Econometrica 46, 1978) is only reported: wrong weights lose efficiency but cause
no bias, so the test does not protect against them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from scalar.diagnosis.fit.fitted_state import FittedState
from scalar.diagnosis.held_out.hold_out import (
    HeldOutErrors,
    held_out_errors,
    held_out_regions,
    improves_with_limited_blocks,
    no_worse,
)
from scalar.diagnosis.selection.harmonic_spectrum import priors_for_whitened_rows
from scalar.diagnosis.shipping.doubtful_effects import equations_per_parameter
from scalar.diagnosis.shipping.focused_choice import FocusedChoice, focused_choice
from scalar.diagnosis.shipping.jackknife import prediction_changes
from scalar.diagnosis.shipping.nested_models import LIMITS, MEASURED
from scalar.effects import Effect
from scalar.geometry.se3 import Array
from scalar.units import MM

BEFORE, EQUAL, BY_COMPONENT = "before", "equal_weights", "weights_of_component"
# Chosen: how much worse the weighted fit may predict held-out poses if its predictions elsewhere differ by no more than chance allows, and a fit with
# effects if a single block of them is all that speaks against it.
TWICE = 2.0


@dataclass(frozen=True)
class Disagreement:
    """How the fit with the weights of a variance component compares with the one with equal weights.

    Attributes:
        difference: Root mean square difference of their predictions at random poses [m], the best rigid motion removed.
        difference_std: Standard error of that difference by the jackknife over poses [m].
        held_out_rms: Held-out errors of the fit with equal weights and of the weighted one [m].
        predicted_std: Standard errors of a predicted position by the jackknife over poses, of the same two fits [m].
        beyond_chance: Whether their predictions differ significantly.
        weights_mislead: Whether they do and the weighted fit predicts held-out poses clearly worse as well, or it predicts them twice as badly.
    """

    difference: float
    difference_std: float
    held_out_rms: tuple[float, float]
    predicted_std: tuple[float, float]
    beyond_chance: bool
    weights_mislead: bool

    def to_mapping(self) -> dict[str, Any]:
        """Return the entry of ``diagnosis.json``."""
        equal, weighted = self.held_out_rms
        std_equal, std_weighted = self.predicted_std
        return {
            "apart_mm": self.difference / MM,
            "apart_std_mm": self.difference_std / MM,
            "beyond_chance": self.beyond_chance,
            "equal_weights": {"held_out_rms_mm": equal / MM, "predicted_std_mm": std_equal / MM},
            "weights_of_component": {"held_out_rms_mm": weighted / MM, "predicted_std_mm": std_weighted / MM},
        }


@dataclass(frozen=True, eq=False)
class ShippedFit:
    """Which fit is shipped, and which comparison decided that.

    Attributes:
        fit: The fit that is shipped: ``before`` (without effects), ``equal_weights`` or ``weights_of_component``.
        effects_fit: The fit with effects: ``equal_weights`` or ``weights_of_component``; the same as ``fit`` unless that is ``before``.
        held_out: Held-out errors of the fit that is shipped.
        effects_held_out: Held-out errors of the fit with effects.
        regions: Errors without and with the effects where whole regions are held out; None without effects or with too few poses.
        decided_by: What decided: ``predicted_std`` or ``held_out`` between the weights; ``undetermined_geometry``, ``extrapolation``,
            ``expected_error``, ``held_out``, ``regions``, ``unseen`` or ``few_poses`` against the effects; ``only_one`` if nothing had to be decided.
        disagreement: The comparison of the weighted fit with that of equal weights; None without a variance component.
        choice: The effects that the fit with effects contains.
        unconfirmed: Those among them that are no findings, because too few runs of the outer split selected them.
    """

    fit: str
    effects_fit: str
    held_out: HeldOutErrors
    effects_held_out: HeldOutErrors
    regions: tuple[HeldOutErrors, HeldOutErrors] | None
    decided_by: str
    disagreement: Disagreement | None
    choice: FocusedChoice
    unconfirmed: tuple[Effect, ...] = ()

    @property
    def rms_with_equal_weights(self) -> float:
        """Return the held-out error of the fit with effects and equal weights [m], which is compared with that of the model without effects."""
        return self.effects_held_out.rms if self.disagreement is None else self.disagreement.held_out_rms[0]

    @property
    def without_effects(self) -> bool:
        """Return whether the model without effects is shipped although effects were found."""
        return self.fit == BEFORE

    def with_unconfirmed(self, refused: Sequence[Effect]) -> ShippedFit:
        """Return the same fit with the effects that are no findings listed apart.

        Args:
            refused: Effects that the outer split does not confirm.
        """

        def is_refused(effect: Effect) -> bool:
            return any(effect.same_place(other) for other in refused)

        choice = self.choice
        return replace(
            self,
            choice=replace(choice, left_out=tuple(e for e in choice.left_out if not is_refused(e))),
            unconfirmed=()
            if self.without_effects
            else tuple(e for e in choice.state.effects if is_refused(e)),
        )

    def to_mapping(self) -> dict[str, Any]:
        """Return the entry of ``diagnosis.json``."""
        found = None if self.disagreement is None else self.disagreement.to_mapping()
        return {
            "fit": self.fit,
            "decided_by": self.decided_by,
            "disagreement": found,
            "regions": None if self.regions is None else _entry_of_regions(*self.regions),
            "unconfirmed": [{"name": effect.name, "target": effect.target} for effect in self.unconfirmed],
        } | self.choice.to_mapping(without_effects=self.without_effects)


def shipped_fit(
    before: FittedState,
    after: FittedState,
    whitening: Array | None,
    unseen: tuple[HeldOutErrors, HeldOutErrors] | None = None,
    *,
    geometry_determined: bool = True,
    unsure: Sequence[str] = (),
) -> ShippedFit:
    """Return which fit to ship.

    Args:
        before: The state without effects.
        after: The state with all effects that were found.
        whitening: ``(N, m, m)``, whitening of the N poses for the variance component that was identified, or None.
        unseen: Errors without and with effects on poses that no part of the diagnosis has used, or None.
        geometry_determined: Whether the poses determine all directions of the geometry. If not, effects may stand for errors of the geometry, and
            are not shipped: held-out poses among those that were measured cannot show how they extrapolate.
        unsure: Keys of effects whose names are doubtful.
    """
    choice = focused_choice(after, unsure)
    after = choice.state
    without, equal = held_out_errors(before), held_out_errors(after)
    fit, held_out, decided_by, found = EQUAL, equal, "only_one", None
    if whitening is not None:
        fit, held_out, decided_by, found = _weights(after, whitening, equal)
    effects_fit, effects_held_out = fit, held_out
    regions = _regions(before, after) if after.effects else None
    against = _against_effects(choice, without, equal, regions, unseen)
    if not geometry_determined and (after.effects or choice.left_out):
        against = "undetermined_geometry"
    if against is not None:
        fit, held_out, decided_by = BEFORE, without, against
    return ShippedFit(fit, effects_fit, held_out, effects_held_out, regions, decided_by, found, choice)


def _weights(
    after: FittedState, whitening: Array, equal: HeldOutErrors
) -> tuple[str, HeldOutErrors, str, Disagreement]:
    """Return the fit with effects whose weights are better, its held-out errors, what decided that, and how the two fits compare.

    Args:
        after: The state with the chosen effects.
        whitening: As for ``shipped_fit``.
        equal: Its held-out errors with equal weights.
    """
    settings = after.settings.shipped_fit
    weighted = held_out_errors(priors_for_whitened_rows(after), whitening)
    of_equal, of_weighted = prediction_changes(after, None), prediction_changes(after, whitening)
    difference, error = of_weighted.difference_from(of_equal)
    beyond_chance = difference > settings.beyond_chance * error
    found = Disagreement(
        difference,
        error,
        (equal.rms, weighted.rms),
        (of_equal.std, of_weighted.std),
        beyond_chance,
        weighted.rms > (settings.clearly_larger_error if beyond_chance else TWICE) * equal.rms,
    )
    if of_weighted.std >= settings.clearly_smaller_std * of_equal.std:
        return EQUAL, equal, "predicted_std", found
    if found.weights_mislead:
        return EQUAL, equal, "held_out", found
    return BY_COMPONENT, weighted, "predicted_std", found


def _against_effects(
    choice: FocusedChoice,
    without: HeldOutErrors,
    equal: HeldOutErrors,
    regions: tuple[HeldOutErrors, HeldOutErrors] | None,
    unseen: tuple[HeldOutErrors, HeldOutErrors] | None,
) -> str | None:
    """Return what decides that the model without effects is shipped; None if the chosen effects are.

    Args:
        choice: The effects.
        without: Held-out errors of the model without effects.
        equal: Those with the effects and equal weights.
        regions: Errors without and with effects in held-out regions, or None.
        unseen: Those on unseen poses, or None.
    """
    after = choice.state
    if not after.effects:
        return "expected_error" if choice.left_out else None
    settings = after.settings.shipped_fit
    # With so few equations, flexible terms may follow the noise of single poses.
    few = equations_per_parameter(after) < settings.least_equations
    if few and all(effect.flexible for effect in after.effects):
        return "few_poses"
    bearable = equal.rms <= TWICE * without.rms
    confirmed = bearable and _promises_much(choice) and improves_with_limited_blocks(without, equal)
    judged = {"held_out": None if confirmed else (without, equal), "regions": regions, "unseen": unseen}
    for name, errors in judged.items():
        if errors and not no_worse(*errors):
            return name
    most = settings.most_extrapolated * max(without.rms, choice.std_without)
    return "extrapolation" if choice.errors_as_chosen[LIMITS] > most else None


def unconfirmed_effects_help(confirmed: FittedState, all_found: FittedState) -> bool:
    """Return whether predictions become worse without the effects that the outer split does not confirm: at held-out poses and in held-out regions.

    The outer split does not confirm an effect if its runs select others in its place. Together these may describe well what the arm does although it
    is open which of them is the cause. The errors on unseen poses are those of runs that correct for all that they select.

    Args:
        confirmed: The fit with the confirmed effects.
        all_found: The fit with all effects that were selected.
    """
    if no_worse(held_out_errors(all_found), held_out_errors(confirmed)):
        return False
    regions = _regions(confirmed, all_found)
    return regions is None or no_worse(*regions)


def _promises_much(choice: FocusedChoice) -> bool:
    """Return whether the chosen effects are expected to reduce the errors so much that the loss at a single held-out block does not count."""
    most = choice.state.settings.shipped_fit.worth_a_block
    return all(choice.errors_as_chosen[k] <= most * choice.errors_without[k] for k in (LIMITS, MEASURED))


def _regions(before: FittedState, after: FittedState) -> tuple[HeldOutErrors, HeldOutErrors] | None:
    """Return the errors without and with effects where whole regions of the joint space are held out; None with too few poses for regions."""
    without, effects = held_out_regions(before), held_out_regions(after)
    return None if without is None or effects is None else (without, effects)


def _entry_of_regions(without: HeldOutErrors, effects: HeldOutErrors) -> dict[str, Any]:
    """Return the entry of ``diagnosis.json`` on held-out regions, from the errors without and with effects."""
    return {
        "count": int(without.block.max()) + 1,
        "without_effects_rms_mm": without.rms / MM,
        "with_effects_rms_mm": effects.rms / MM,
    }
