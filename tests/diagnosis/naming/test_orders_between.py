"""Harmonics whose orders are not whole have no sure name; those of a gear on the joint keep it."""

from types import SimpleNamespace

import numpy as np
import pytest

from scalar.diagnosis.naming import orders_between
from scalar.diagnosis.naming.most_confidence import ONE_OF_TWO
from scalar.diagnosis.naming.orders_between import (
    LEAST_CHANCE,
    LEAST_DISTANCE,
    NOT_WHOLE,
    chance_of_whole_orders,
    limited_by_orders_between,
)
from scalar.effects.joint_harmonic import JointHarmonic
from scalar.effects.joint_scale import JointScale
from tests.diagnosis.naming.test_akaike_rivals import tracked
from tests.diagnosis.stand_ins import finding_of
from tests.diagnosis.test_noise_within_scans import before

LEAST = 0.6


def chance(order: float, seed: int) -> tuple[float, float]:
    """Return the p-value of whole orders, and the distance of the true one.

    Joint 3 errs with ``order`` periods a turn over 1.5 rad to either side, and order 6 is fitted.
    """
    state = before(tracked(seed, lambda angle: 3e-4 * np.sin(order * angle + 0.4), most=1.5))
    fitted = state.refitted([JointHarmonic(3, (6,))])
    (effect,) = fitted.effects
    assert isinstance(effect, JointHarmonic)
    return chance_of_whole_orders(effect, fitted)


def test_orders_between_whole_ones_are_seen():
    """Six periods a turn are whole in at least four of five campaigns; six and a third are not in any."""
    assert sum(chance(6.0, seed)[0] >= LEAST_CHANCE for seed in range(5)) >= 4
    assert all(chance(6.33, seed)[0] < LEAST_CHANCE for seed in range(5))


def test_the_distance_is_that_of_the_true_order():
    """Six and a fifth periods a turn are 0.2 from whole in the median of five campaigns, to the derivative's first order, and six are whole."""
    assert np.median([chance(6.2, seed)[1] for seed in range(5)]) == pytest.approx(0.2, rel=0.25)
    assert np.median([chance(6.0, seed)[1] for seed in range(5)]) < LEAST_DISTANCE


def test_the_change_with_the_order_is_its_derivative():
    """It is the difference quotient of the error, of each order alone."""
    q, coefficients = np.linspace(-2.0, 2.0, 50), np.array([3.0, -1.0, 0.5, 2.0])
    effect = JointHarmonic(2, (3, 7), coefficients=coefficients)
    step = 1e-6
    for k, order in enumerate(effect.orders):
        s, c = coefficients[2 * k : 2 * k + 2]
        up, down = (s * np.sin(m * q) + c * np.cos(m * q) for m in (order + step, order - step))
        assert effect.change_with_orders(q)[:, k] == pytest.approx((up - down) / (2 * step), abs=1e-6)


@pytest.mark.parametrize(
    ("effect", "chance", "limited"),
    [
        (JointHarmonic(3, (6,), coefficients=np.ones(2)), (0.001, 0.3), True),
        (JointHarmonic(3, (6,), coefficients=np.ones(2)), (0.001, 0.02), False),
        (JointHarmonic(3, (6,), coefficients=np.ones(2)), (0.3, 0.3), False),
        (JointHarmonic(3, (6, 7, 8), coefficients=np.ones(6)), (0.3, 0.0), True),
        (JointHarmonic(3, (1, 2, 3), coefficients=np.ones(6)), (0.3, 0.0), False),
        (JointHarmonic(3, (6, 7, 12), coefficients=np.ones(6)), (0.3, 0.0), False),
        (JointScale(3), (0.001, 0.3), False),
    ],
    ids=[
        "not whole",
        "nearly whole",
        "whole",
        "high orders in a row",
        "low orders in a row",
        "two in a row",
        "a scale",
    ],
)
def test_only_harmonics_that_may_not_be_whole_are_limited(monkeypatch, effect, chance, limited):
    """A harmonic is limited if a test refuses whole orders, or if three high orders stand in a row."""
    monkeypatch.setattr(orders_between, "chance_of_whole_orders", lambda *_: chance)
    (found,) = limited_by_orders_between([finding_of(effect, 0.95)], SimpleNamespace(), LEAST)
    assert (found.confidence, found.limit) == ((ONE_OF_TWO, NOT_WHOLE) if limited else (0.95, ""))
