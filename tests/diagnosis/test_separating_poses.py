"""Where two confounded effects would predict different positions."""

import numpy as np

from scalar.diagnosis.fitted_state import refit
from scalar.diagnosis.separating_poses import _steps
from scalar.effects.joint_scale import JointScale
from scalar.estimation.geometry_fit import geometry_fit
from tests.effects.injected import Flaws, make_cell


def test_an_effect_is_explained_by_itself_whatever_varies_between_poses():
    """Of two equal effects the other takes over all of it, and nothing else moves, with a variance component as without:
    the columns of both are whitened alike.
    """
    dataset = make_cell(Flaws(jitter=2e-4), seed=3).dataset
    model, prepared = geometry_fit(dataset)
    effect = JointScale(2, coefficients=np.array([1e-3]))
    state = refit(dataset, model, prepared.free, (effect,))
    assert state.whitening is not None
    steps = _steps(state, 0, JointScale(2))
    assert steps is not None
    own = state.effects[0].coefficients[0]
    scaled = steps[: len(state.model.vector) - 1] / np.abs(own)
    assert np.max(np.abs(scaled)) < 1e-6
    np.testing.assert_allclose(steps[-2:], [own, -own], rtol=1e-6)
