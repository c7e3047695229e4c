"""A variance component that moves nothing at most poses is estimated from the others, and is no fault."""

import numpy as np

from scalar.diagnosis.fit.background import Background
from scalar.diagnosis.noise.restricted_likelihood import fit_components


def test_a_component_that_acts_at_few_poses_is_estimated():
    """A tracker's target on the axis of a joint shows nothing of its scatter at most poses but rounding; the estimate comes from the rest."""
    rng = np.random.default_rng(7)
    columns = rng.normal(size=(300, 3)) * np.where(np.arange(300) < 100, 1.0, 1e-16)[:, None]
    residual = rng.normal(size=(300, 3)) + columns * 2.0 * rng.normal(size=(300, 1))
    background = Background.of(residual.ravel(), np.eye(900)[:, :1], 300, 3)
    kernel = columns[:, :, None] * columns[:, None, :]
    assert 2.5 < fit_components(background, [kernel]).variances[0] < 5.5
