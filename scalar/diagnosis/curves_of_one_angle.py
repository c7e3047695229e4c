"""Compare effects that are errors of the same joint over its own angle by Akaike's information criterion.

An error proportional to a joint's angle, and a harmonic of its gear, are both curves over that angle. Where a joint moves over a part of a turn, they
may be nearly the same curve. The evidence of the diagnosis, half the drop of the Bayesian information criterion (``score_test.evidence``), then
prefers the curve with fewer coefficients by some 3 nats for each coefficient that the other has more, although the data do not say which of the two
the joint has: all gears have harmonics, and few encoders a wrong scale. Between curves over the same angle, a further coefficient therefore counts
as 1 nat, as in Akaike's criterion (Burnham and Anderson, Model selection and multimodel inference, 2nd edition, 2002, chapter 2).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.special import expit

from scalar.diagnosis.background import Background
from scalar.diagnosis.ranking import Scored
from scalar.diagnosis.score_test import remainder


def compared_by_akaike(own: Scored, ranking: Sequence[Scored], background: Background) -> list[Scored]:
    """Return scores of candidates, best first, in which other curves over the same angle are behind an effect as far as Akaike's criterion says.

    Args:
        own: The score of the effect.
        ranking: The scores of the candidates in its place.
        background: The model without the effect, to which all these scores refer.
    """
    scores = [
        replace(s, evidence=max(s.evidence, own.evidence - _lag(own, s, background)))
        if _is_longer_curve(own, s)
        else s
        for s in ranking
    ]
    return sorted(scores, key=lambda s: -s.evidence)


def akaike_weight(own: Scored, ranking: Sequence[Scored]) -> float:
    """Return the probability of an effect among the curves over its joint's angle, if each is as likely beforehand; 1 without other such curves.

    Args:
        own: The score of the effect.
        ranking: What ``compared_by_akaike`` returns.
    """
    curves = [s.evidence for s in ranking if _is_longer_curve(own, s)]
    return float(expit(own.evidence - np.logaddexp.reduce(curves))) if curves else 1.0


def _is_longer_curve(own: Scored, other: Scored) -> bool:
    """Return whether another score is that of a named curve over the same joint's angle with more coefficients."""
    joint = own.effect.own_angle_joint
    return (
        joint is not None
        and other.effect.own_angle_joint == joint
        and not other.effect.flexible
        and other.dof > own.dof
    )


def _lag(own: Scored, other: Scored, background: Background) -> float:
    """Return half the difference of Akaike's criterion [nats] by which another score's effect is behind the own one; 0 if it is ahead."""
    rest, _ = remainder(background, np.array([own.gain, other.gain]), np.array([own.dof, other.dof]))
    worse_fit = 0.5 * background.degrees_of_freedom * float(np.log(rest[1] / rest[0]))
    return max(worse_fit + (other.dof - own.dof), 0.0)
