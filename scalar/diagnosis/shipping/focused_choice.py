"""Choose which effects the shipped model contains: those with which predictions at other poses are expected to have the smallest error.

An effect may be significant although its correction does harm. An error of the scanner over its range, for example, is almost equivalent to a
change of the arm's lengths, and if its assumed form is wrong, it biases them. The focused information criterion (Claeskens and Hjort, Journal of
the American Statistical Association 98, 2003) estimates the mean squared error of a quantity, here of predicted positions at random poses, for
every model nested in a wide one. This mean squared error is the sum of the variance and the squared bias. The squared bias is estimated by the
squared difference from the wide model's prediction, less the squared difference that is expected by chance alone. Here the latter is multiplied by
``settings.shipped_fit.beyond_chance`` squared before it is subtracted, because a correction that does harm is worse than one that is missing. The
variances are those of the jackknife over poses (``jackknife``), which is valid for any noise within a pose.

The wide model contains all effects that were found. If one of them is a special case of a more general effect, the wide model contains that effect as
well; the general effect is never shipped and only shows the bias of the others. The wide model also contains nuisances, deviations that every set-up
has to a small degree (``Effect.in_every_setup``): for example, no target plane is perfectly flat. These may be shipped too, although they are no
findings: if one target plane is bowed, for example, the arm is estimated more accurately if the smaller bows of the other planes are fitted as well.
A nuisance is shipped only if it is significant. The expected errors alone do not show that it is not there: it is then fitted to the noise, and the
squared bias that it seems to remove has an error of its own.

Of the effects without a sure name, some are not shipped whatever errors are expected: changes among the last few poses, and a scale of all lengths.
The others have to help clearly, because their form is a guess (``doubtful_effects``).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from scalar.diagnosis.fit.fitted_state import FittedState, plausibly_refitted
from scalar.diagnosis.settings import Settings
from scalar.diagnosis.shipping.doubtful_effects import with_doubtful_that_help
from scalar.diagnosis.shipping.nested_models import LIMITS, MEASURED, RANGES, Errors, NestedModels
from scalar.effects import Effect
from scalar.effects.registry import missing_nuisances
from scalar.units import MM


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
            },
        }


def focused_choice(after: FittedState, unsure: Sequence[str] = ()) -> FocusedChoice:
    """Return the effects with which predictions are expected to err least.

    Effects are left out one after the other as long as the expected error falls; in each step the one is left out without which the error is
    smallest. This is done from the effects that were found, from these together with the significant nuisances, and from those with a sure name
    together with the nuisances that are significant given them: where the planes are bowed, doubtful effects may stand for the bows. The best of
    the results is chosen if two conditions hold: its error within the joint limits is clearly smaller than with all effects that were found
    (``settings.shipped_fit.clearly_smaller_error``), and its errors are no larger within the measured ranges of the joints and at the measured poses.
    Else all effects that were found are kept. The second condition keeps a correction that is uncertain only where nothing was measured. The ranges
    alone are not enough for it: poses that press a tool on target planes, for example, fill a small part of the ranges, and predictions for the rest
    are not determined.

    Effects without a sure name have to pass further tests (``doubtful_effects``). Nuisances are shipped together with effects that were found, never
    alone. Finally, no effect is shipped if the error remains above ``settings.shipped_fit.worth_correcting`` times that of the model without effects,
    both within the joint limits and at the measured poses. The share is smaller if one error of the instrument may be what another leaves, and no
    effect of the arm is corrected (``_has_remainder``).

    Args:
        after: The state with all effects that were found.
        unsure: Keys of those among them whose names are doubtful. Flexible terms have no name.
    """
    effects = after.effects
    if not effects:
        alone = NestedModels(after)
        errors = alone.errors(())
        return FocusedChoice(after, (), (), errors[LIMITS], errors, errors, alone.std(()))
    nuisances, general = missing_nuisances(after.dataset, effects), _general(after)
    everything = (*effects, *nuisances, *general)
    wide = NestedModels(after.refitted(everything, after.model) if len(everything) > len(effects) else after)
    found = tuple(range(len(effects)))
    with_all, without = wide.errors(found), wide.errors(())
    doubtful = [i for i in found if effects[i].flexible or effects[i].key in unsure]
    sure, others = tuple(i for i in found if i not in doubtful), tuple(range(len(found), len(everything)))
    kept = _with_least_error(wide, (found, sure), others, len(nuisances), after.settings)
    kept = with_doubtful_that_help(wide, kept, doubtful, after)
    errors, shipping = wide.errors(kept), after.settings.shipped_fit
    remainder = _has_remainder([everything[i] for i in kept])
    worth = shipping.worth_remainder if remainder else shipping.worth_correcting
    if not set(kept) & set(found) or all(errors[k] > worth * without[k] for k in (LIMITS, MEASURED)):
        kept, errors = (), without
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


def _has_remainder(effects: Sequence[Effect]) -> bool:
    """Return whether effects are errors of the instrument and none of the arm, and one of them may be what another leaves.

    An error over a scanner's profile never has exactly the form of the effect that stands for it. The remainder is taken for an error of the range,
    which is almost confounded with the arm's lengths, so that the correction errs by more than its linear comparison with a wide model shows.
    """
    of_instrument = [effect for effect in effects if effect.of_instrument]
    approximate = any(effect.any_smooth_form for effect in of_instrument)
    return approximate and len(of_instrument) > 1 and not any(effect.acts_on_arm for effect in effects)


def _with_least_error(
    wide: NestedModels,
    starts: Sequence[tuple[int, ...]],
    others: tuple[int, ...],
    n_nuisances: int,
    settings: Settings,
) -> tuple[int, ...]:
    """Return the indices of the effects that remain after the best elimination if their errors are clearly smaller, else those that were found.

    Args:
        wide: The wide model and the models nested in it.
        starts: Indices of the effects that were found, and of those among them that have a sure name. Eliminations start from the former as they
            are, and from each of the two with the nuisances that are significant given it and all ``others``.
        others: Indices of the nuisances and of the general effects.
        n_nuisances: Number of nuisances, the first of the others.
        settings: Thresholds.
    """
    found, alpha = starts[0], settings.selection.alpha_named_effect
    with_all, more = wide.errors(found), {found}
    for start in starts:
        more.add((*start, *(i for i in others[:n_nuisances] if wide.p_value(i, (*start, *others)) <= alpha)))
    kept = min(
        (_eliminated(wide, start, with_all) for start in sorted(more)),
        key=lambda kept: wide.errors(kept)[LIMITS],
    )
    errors, clearly = wide.errors(kept), settings.shipped_fit.clearly_smaller_error
    smaller = errors[LIMITS] <= clearly * with_all[LIMITS] and _no_worse(errors, with_all)
    return kept if smaller else found


def _general(after: FittedState) -> list[Effect]:
    """Return a list of at most one effect of which a found effect is a special case; several general effects would be almost equivalent."""
    general = (effect.generalised(after.dataset) for effect in after.effects)
    return [
        effect
        for effect in general
        if effect is not None and not any(effect.same_place(other) for other in after.effects)
    ][:1]


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
