"""How sure an answer is: the share of the evidence that speaks for it, as far as answers like it have been right.

With evidences in nats (half the drop of the Bayesian information criterion, less the log of how many of a kind were tried) the odds
against an answer, among all that was tried and nothing at all, are ``exp(-E) + sum exp(E_k - E)``. They would be right if the truth were
among what was tried, and nothing but Gaussian noise in addition. Neither need be: an effect of no known name, a place that is nearly right.
So the log odds count for less, and no answer is surer than answers that seemed sure have been; both numbers are fitted to the answers of
the blind trials, whose sets hold effects of every size and of no known name.
"""

from __future__ import annotations

from scipy.special import expit

from scalar.diagnosis.grounds import EFFECT, Grounds
from scalar.diagnosis.settings import DEFAULTS, ConfidenceSettings


def confidence(grounds: Grounds, settings: ConfidenceSettings = DEFAULTS.confidence) -> float:
    """Return the chance that an answer is right, 0 to ``settings.most``."""
    beside = grounds.kind == EFFECT and grounds.beside_structure
    most = min(settings.most, settings.beside_unmodelled) if beside else settings.most
    return float(most * expit(grounds.log_odds / settings.temperature))
