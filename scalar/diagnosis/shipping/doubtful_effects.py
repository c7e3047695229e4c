"""Which effects without a sure name the shipped model contains.

Their form is a guess, and they may have been selected by chance from many. They therefore have to help more clearly than effects with a sure name,
and four kinds are not shipped whatever errors are expected: changes among the last few poses, a scale of all lengths, errors of a joint that
stands at few positions, and changes in time of poses that follow one path.
"""

from __future__ import annotations

import numpy as np

from scalar.data.motion import at_few_positions
from scalar.diagnosis.fit.fitted_state import FittedState
from scalar.diagnosis.held_out.repetitions import distinct_equations
from scalar.diagnosis.shipping.nested_models import LIMITS, NestedModels
from scalar.effects import Effect
from scalar.effects.acquisition import on_one_path
from scalar.effects.title import only_joint

LATE = 0.1  # chosen: of the poses; a change that fewer of them show may as well be a few poses that err


def with_doubtful_that_help(
    wide: NestedModels, kept: tuple[int, ...], doubtful: list[int], after: FittedState
) -> tuple[int, ...]:
    """Return the effects that are kept, without those among them that have no sure name and do not help clearly.

    A change that begins among the last few poses (``LATE``) and has no sure name is not shipped: it would be applied to every later pose. Nor is an
    error of the scale of all lengths: held-out poses do not show whether it is right. Nor is an error of one joint that stands at few positions, as
    on a grid: held-out poses stand at the same ones, and nothing shows it between them. Nor is a change in time of poses that follow one path, which
    may as well depend on the place. Other changes in time without a sure name are shipped only if the expected error without them, or without any
    effects, is far larger (``settings.shipped_fit.worth_doubtful``): their form is a guess, and the arm itself need not have changed. Other effects
    without a sure name have to remove as much within the joint limits as all effects together have to
    (``settings.shipped_fit.worth_correcting``).

    Effects without a sure name may have been selected by chance from many. If few equations are measured for each parameter of the geometry
    (``settings.shipped_fit.few_equations``), and no effect with a sure name is shipped but nuisances, they are therefore shipped only if the F
    statistic of their reduction of the sum of squares is large (``settings.shipped_fit.least_f_statistic``).

    Args:
        wide: The nested models.
        kept: Indices of the effects that are kept so far; those that were found come before all others.
        doubtful: Indices of the effects that were found and have no sure name.
        after: The state with all effects that were found.
    """
    effects, shipping = after.effects, after.settings.shipped_fit
    few = at_few_positions(after.dataset.q)
    in_time = [i for i in doubtful if _changes_in_time(effects[i])]
    on_path = in_time if in_time and on_one_path(after.dataset) else []
    unshown = [
        i
        for i in doubtful
        if _is_late(effects[i], after)
        or effects[i].stretches_lengths
        or only_joint(effects[i].target, effects[i].depends_on) in few
        or i in on_path
    ]
    kept = _without(kept, unshown)
    for which, worth in ((in_time, shipping.worth_doubtful), (doubtful, shipping.worth_correcting)):
        if not _is_worth_correcting(wide, kept, which, worth):
            kept = _without(kept, which)
    sure = [effects[i] for i in kept if i < len(effects) and i not in doubtful]
    none_is_sure = all(effect.in_every_setup for effect in sure)
    if none_is_sure and not _explain_much(wide, kept, doubtful, after):
        kept = _without(kept, doubtful)
    return kept


def equations_per_parameter(state: FittedState) -> float:
    """Return the number of equations that were measured at distinct poses for each free parameter of robot, sensor and target."""
    return distinct_equations(state) / max(int(state.geometry_free.sum()), 1)


def _without(kept: tuple[int, ...], doubtful: list[int]) -> tuple[int, ...]:
    """Return the indices of the effects that were chosen but for the doubtful ones."""
    return tuple(i for i in kept if i not in doubtful)


def _is_worth_correcting(
    wide: NestedModels, kept: tuple[int, ...], doubtful: list[int], worth: float
) -> bool:
    """Return whether so much is expected of correcting for doubtful effects that it is done.

    Args:
        wide: The wide model and the models nested in it.
        kept: Indices of the effects that were chosen.
        doubtful: Indices of the doubtful ones.
        worth: Largest share of the expected error within the joint limits that doubtful effects may leave. They are kept as well if at most the
            square of this share remains of the expected error without any effects: predictions can then hardly become worse than those.
    """
    error, without = (wide.errors(which)[LIMITS] for which in (kept, _without(kept, doubtful)))
    return error <= worth * without or error <= worth**2 * wide.errors(())[LIMITS]


def _explain_much(wide: NestedModels, kept: tuple[int, ...], doubtful: list[int], after: FittedState) -> bool:
    """Return whether doubtful effects explain much of the residual, or many equations are measured; also if none of them was chosen.

    Args:
        wide, kept, doubtful: As for ``_is_worth_correcting``.
        after: The state with all effects that were found.
    """
    settings, chosen = after.settings.shipped_fit, tuple(i for i in kept if i in doubtful)
    if not chosen or equations_per_parameter(after) >= settings.few_equations:
        return True
    return wide.f_statistic(chosen, kept) >= settings.least_f_statistic


def _changes_in_time(effect: Effect) -> bool:
    """Return whether an effect changes in the course of the acquisition, by its clock or by the order of the poses."""
    return effect.is_change_in_time or bool({"time", "order"} & set(effect.depends_on))


def _is_late(effect: Effect, after: FittedState) -> bool:
    """Return whether an effect is a change that begins among the last few poses."""
    since = effect.since(after.residuals.poses)
    return since is not None and float(np.mean(since)) < LATE
