"""How sure an answer is: the share of the evidence that speaks for it, as far as answers like it have been right.

With evidences in nats (half the drop of the Bayesian information criterion, less the log of how many of a kind were tried) the odds
against an answer, among all that was tried and nothing at all, are ``exp(-E) + sum exp(E_k - E)``. They would be right if the truth were
among what was tried, and nothing but Gaussian noise in addition. Neither need be: an effect of no known name, a place that is nearly right.
So the log odds count for less, and no answer is surer than answers that seemed sure have been; both numbers are fitted to the answers of
the blind trials, whose sets hold effects of every size and of no known name.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.special import expit

from scalar.diagnosis.settings import DEFAULTS, ConfidenceSettings


def confidence(
    own: float,
    others: Sequence[float],
    settings: ConfidenceSettings = DEFAULTS.confidence,
    beside_unmodelled: bool = False,
) -> float:
    """Return the chance that an answer is right, 0 to ``settings.most``.

    Args:
        own: Its evidence [nats].
        others: Those of everything else that would answer otherwise [nats].
        settings: Temperature and largest confidence.
        beside_unmodelled: Whether it is a name, and structure without one was found as well.
    """
    against = float(np.logaddexp.reduce([-own, *(other - own for other in others)]))
    most = min(settings.most, settings.beside_unmodelled) if beside_unmodelled else settings.most
    return float(most * expit(-against / settings.temperature))
