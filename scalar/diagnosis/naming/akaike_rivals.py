"""Compare effects that by their nature imitate one another by Akaike's information criterion.

The evidence of the diagnosis is half the drop of the Bayesian information criterion, less the logarithm of the number of candidates of the effect's
kind (``score_test.evidence``). Between two kinds of effects it is not fair to the data if one imitates the other:

- An error proportional to a joint's angle, and a harmonic of its gear, are both curves over that angle. Where a joint moves over a part of a turn,
  they may be nearly the same curve. The evidence then prefers the curve with fewer coefficients by some 3 nats for each coefficient that the other
  has more, although all gears have harmonics, and few encoders a wrong scale.
- A joint that gives way under the weight of its own link alone, and an eccentric gear that errs once a turn, are the same curve over the angle of a
  joint with a horizontal axis. Whether the links after it load the joint as well is what distinguishes them.
- The base and the joints of an arm give way under the same weight. Where the second joint is near the base, both move the arm in nearly the same
  way. The evidence then prefers the base, because there is one base and there are several joints, although joints are no stiffer than bases.

Among such effects, a further coefficient therefore counts as 1 nat, as in Akaike's criterion (Burnham and Anderson, Model selection and multimodel
inference, 2nd edition, 2002, chapter 2), and the number of candidates does not count.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np
from scipy.special import expit

from scalar.data.io.atomic import plain
from scalar.diagnosis.fit.background import Background
from scalar.diagnosis.scoring.ranking import Scored
from scalar.diagnosis.scoring.score_test import remainder
from scalar.effects import BaseEffect, Effect


def compared_by_akaike(own: Scored, ranking: Sequence[Scored], background: Background) -> list[Scored]:
    """Return scores of candidates, best first, in which those that imitate an effect are behind it as far as Akaike's criterion says.

    Args:
        own: The score of the effect.
        ranking: The scores of the candidates in its place.
        background: The model without the effect, to which all these scores refer.
    """
    scores = [
        replace(s, evidence=max(s.evidence, own.evidence - _lag(own, s, background)))
        if _imitates(own, s)
        else s
        for s in ranking
    ]
    return sorted(scores, key=lambda s: -s.evidence)


def akaike_weight(own: Scored, ranking: Sequence[Scored]) -> float:
    """Return the probability of an effect among those that imitate it, if each is as likely beforehand; 1 without any.

    Args:
        own: The score of the effect.
        ranking: What ``compared_by_akaike`` returns. Of several scores with the same name and target, the first counts.
    """
    return weight_among(own, (s for s in ranking if _imitates(own, s)))


def weight_among(own: Scored, rivals: Iterable[Scored]) -> float:
    """Return the probability of an effect among rivals, best first, if each is as likely beforehand; 1 without any.

    Of several scores with the same name and target, the first counts.
    """
    evidence: dict[str, float] = {}
    for s in rivals:
        evidence.setdefault(name_and_target(s.effect), s.evidence)
    return float(expit(own.evidence - np.logaddexp.reduce(list(evidence.values())))) if evidence else 1.0


def name_and_target(effect: Effect) -> str:
    """Return the name and the target of an effect as one text, by which answers are compared."""
    return f"{effect.name} {json.dumps(plain(effect.target), sort_keys=True)}"


def _imitates(own: Scored, other: Scored) -> bool:
    """Return whether another score is that of a longer curve over the same joint's angle, of a curve over the angle of a joint that gives way under
    the weight of its own link alone, or the reverse, or of the base where joints give way, or the reverse.

    Flexible terms imitate nothing: they have no name that could be the right one. Nor does one description of a joint that gives way imitate
    another, by its measured torque or by the weight of the arm: the cause is the same.
    """
    effect, rival = own.effect, other.effect
    if rival.flexible:
        return False
    joint = effect.own_angle_joint
    if joint is not None and rival.own_angle_joint == joint and other.dof > own.dof:
        return True
    if rival.own_angle_joint in effect.own_weight_joints or joint in rival.own_weight_joints:
        return True
    same_load = bool(effect.load) and rival.load == effect.load
    return same_load and isinstance(effect, BaseEffect) != isinstance(rival, BaseEffect)


def _lag(own: Scored, other: Scored, background: Background) -> float:
    """Return half the difference of Akaike's criterion [nats] by which another score's effect is behind the own one; 0 if it is ahead."""
    rest, _ = remainder(background, np.array([own.gain, other.gain]), np.array([own.dof, other.dof]))
    worse_fit = 0.5 * background.degrees_of_freedom * float(np.log(rest[1] / rest[0]))
    return max(worse_fit + (other.dof - own.dof), 0.0)
