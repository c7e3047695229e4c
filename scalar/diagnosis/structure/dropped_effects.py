"""Drop named effects that only fit a part of the unmodelled structure that flexible terms describe."""

from __future__ import annotations

from collections.abc import Sequence

from scalar.data.poses import is_joint
from scalar.diagnosis.fit.background import Background
from scalar.diagnosis.fit.fitted_state import FittedState, plausibly_refitted
from scalar.diagnosis.held_out.hold_out import held_out_errors
from scalar.diagnosis.noise.autocorrelation import depends_on
from scalar.diagnosis.scoring.conditional_scores import columns_of_effects, without_columns
from scalar.diagnosis.structure.replaced_names import MOST_GROWTH


def without_effects_of_same_curve(state: FittedState) -> FittedState:
    """Return a state without the named effects of a joint's own angle if a flexible term over the same angle explains more than they do.

    Such effects only fit what the flexible term leaves of the same curve. If they explain more than the term, it is the term that fits what they
    leave, and nothing is dropped.
    """
    plain, dropped = state.background_within_scans(), set[int]()
    for joint in {effect.own_angle_joint for effect in state.effects if effect.flexible} - {None}:
        curves = [i for i, effect in enumerate(state.effects) if effect.own_angle_joint == joint]
        named = [i for i in curves if not state.effects[i].flexible]
        flexible = [i for i in curves if state.effects[i].flexible]
        if named and _explained(state, plain, named) <= _explained(state, plain, flexible):
            dropped.update(named)
    if not dropped:
        return state
    return plausibly_refitted(state, [effect for i, effect in enumerate(state.effects) if i not in dropped])


def without_minor_effects(state: FittedState) -> FittedState:
    """Return a state without the named effects that explain little compared with the unmodelled structure, since they are as likely a part of it.

    The unmodelled structure is what the flexible terms explain and, if residuals are autocorrelated, what remains beyond the noise within scans. If
    it depends on anything but joints (time, a recorded column, gravity, the place on a plane), a change in time has to explain more than all of it.
    Any other named effect has to explain more than the share ``minor_share`` of it. None is dropped if held-out poses are then predicted much worse
    (``MOST_GROWTH``): what the flexible terms cannot stand for is no part of the structure that they describe, however large that is.
    """
    plain, settings = state.background_within_scans(), state.settings.flexible_terms
    flexible_terms = [i for i, effect in enumerate(state.effects) if effect.flexible]
    columns = [v for i in flexible_terms for v in state.effects[i].depends_on]
    structure = _explained(state, plain, flexible_terms) if flexible_terms else 0.0
    along = depends_on(state) if state.variance_components else []
    if along:
        structure += max(plain.sum_of_squares - plain.degrees_of_freedom, 0.0)
    not_of_joints_alone = any(not is_joint(name) for name in [*columns, *along])
    minor = [
        i
        for i, effect in enumerate(state.effects)
        if i not in flexible_terms
        and _explained(state, plain, [i])
        < (1.0 if not_of_joints_alone and effect.is_change_in_time else settings.minor_share) * structure
    ]
    if not minor:
        return state
    smaller = plausibly_refitted(state, [effect for i, effect in enumerate(state.effects) if i not in minor])
    return state if held_out_errors(smaller).rms > MOST_GROWTH * held_out_errors(state).rms else smaller


def _explained(state: FittedState, plain: Background, indices: Sequence[int]) -> float:
    """Return by how much the squared residual of ``plain``, the background within scans, would grow without the effects ``indices``."""
    local, _ = columns_of_effects(state, indices)
    return without_columns(plain, state, local).sum_of_squares - plain.sum_of_squares
