"""Find poses between two changes of one kind that follow each other within a few poses: these are gross errors rather than two changes.

Two wrong poses in a row look like a tracker that was knocked before the first and knocked back after the second. The two changes explain the poses as
well as two gross errors do, but any right pose between them would be corrected for a shift that never happened.
"""

from __future__ import annotations

import itertools

import numpy as np

from scalar.diagnosis.fit.fitted_state import FittedState
from scalar.effects.acquisition import on_plane
from scalar.geometry.robot import BoolArray


def between_brief_changes(state: FittedState) -> BoolArray:
    """Return which poses of a state ``(N,)`` bool lie between two of its changes that act at one place, fewer than a run of poses apart.

    A run has ``settings.estimation.gross_errors.contiguous_run`` poses.
    """
    dataset, most = state.dataset, state.settings.estimation.gross_errors.contiguous_run
    found = np.zeros(dataset.n_poses, dtype=bool)
    order = dataset.known_poses.order
    changes = [
        (effect, order >= effect.target["at"]["order"]) for effect in state.effects if "at" in effect.target
    ]
    for (one, since), (other, later) in itertools.combinations(changes, 2):
        between = since != later
        if "plane" in one.target:
            between &= on_plane(dataset, one.target["plane"])
        if one.same_place(other) and 0 < np.count_nonzero(between) < most:
            found |= between
    return found
