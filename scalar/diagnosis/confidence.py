"""How sure an answer is: the share of the evidence that speaks for it, as far as answers like it have been right.

With evidences in nats (half the drop of the Bayesian information criterion, less the log of how many of a kind were tried) an answer's
share among all that was tried, and nothing at all, is ``1 / (1 + exp(-E) + sum exp(E_k - E))``. That holds if the truth is among what was
tried. It need not be: so no answer is surer than answers that seemed sure have been in the closed loop, whose sets hold effects of no known name.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

MOST = 0.99  # share of the answers that seemed sure which were right


def confidence(own: float, others: Sequence[float]) -> float:
    """Return the chance that an answer is right, 0 to ``MOST``.

    Args:
        own: Its evidence [nats].
        others: Those of everything else that would answer otherwise [nats].
    """
    exponents = np.array([-own, *(other - own for other in others)])
    return float(MOST / (1.0 + np.sum(np.exp(np.minimum(exponents, 700.0)))))
