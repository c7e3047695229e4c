"""Orders of a joint that were chosen one by one from few poses are a doubtful name, because a random error of the joint chooses as many."""

import numpy as np
import pytest

from scalar.diagnosis.naming.many_orders import (
    POSES_PER_ORDER,
    TOO_FEW_POSES,
    limited_by_many_orders,
)
from scalar.diagnosis.naming.most_confidence import ONE_OF_TWO
from scalar.effects.joint_harmonic import JointHarmonic
from scalar.effects.joint_scale import JointScale
from tests.diagnosis.stand_ins import finding_of

LEAST, MANY = 0.6, 4
SEVEN = (3, 8, 10, 11, 26, 27, 32)


def with_orders(orders):
    """Return an error of joint 3 in some orders."""
    return JointHarmonic(3, orders, coefficients=np.zeros(2 * len(orders)))


@pytest.mark.parametrize(
    ("effect", "n_poses", "doubtful"),
    [
        (with_orders(SEVEN), 50, True),
        (with_orders(SEVEN), 60, False),
        (with_orders((2,)), 30, False),
        (with_orders(tuple(range(1, 33))).with_term_std([1e-5] * 32), 100, False),
        (JointScale(3), 20, False),
    ],
    ids=["seven orders", "of more poses", "one order", "all orders", "no orders"],
)
def test_many_orders_of_few_poses_are_doubtful(effect, n_poses, doubtful):
    """A name is limited by the number of its orders; all orders at once have priors, and other names have no orders."""
    (found,) = limited_by_many_orders([finding_of(effect, 0.9)], n_poses, MANY, LEAST)
    assert found.doubtful == doubtful
    assert found.confidence == (ONE_OF_TWO if doubtful else 0.9)
    assert found.limit == (TOO_FEW_POSES if doubtful else "")


def test_a_limit_above_the_confidence_is_no_reason():
    """A name that had less confidence than the limit keeps it, and the limit is not stated as its reason; of two limits, the lower one is."""
    finding = finding_of(JointScale(3), 0.4)
    kept = finding.limited(0.5, LEAST, "a rule")
    assert (kept.confidence, kept.doubtful, kept.limit) == (0.4, True, "")
    assert finding.limited(0.3, LEAST, "one").limited(0.2, LEAST, "two").limit == "two"
    assert finding.limited(0.2, LEAST, "one").limited(0.3, LEAST, "two").limit == "one"


@pytest.mark.parametrize(
    ("orders", "joint", "doubtful"),
    [((1, 3, 4, 6, 8), 3, True), ((1, 3, 4, 6, 8), 2, False), ((1, 2), 3, False)],
    ids=["same joint", "another joint", "few orders"],
)
def test_a_scale_beside_many_orders_of_its_joint_may_be_one_of_them(orders, joint, doubtful):
    """The orders keep their name; the scale of the same joint is doubtful."""
    found = [finding_of(with_orders(orders), 0.96), finding_of(JointScale(joint), 0.7)]
    gear, scale = limited_by_many_orders(found, 60, MANY, LEAST)
    assert gear.confidence == 0.96 and not gear.doubtful
    assert scale.doubtful == doubtful and scale.confidence == (ONE_OF_TWO if doubtful else 0.7)


@pytest.mark.parametrize(("times", "more_than_half"), [(0.9, True), (2.0, False)])
def test_so_few_poses_let_random_errors_choose_orders(times, more_than_half):
    """Of 32 orders, the best seven explain more than half of random errors with fewer than eight poses each, and less with twice as many."""
    rng = np.random.default_rng(4)
    n = round(times * POSES_PER_ORDER * len(SEVEN))
    shares = [
        explained_by_best(rng.uniform(-3.0, 3.0, n), rng.choice([-1.0, 1.0], n), len(SEVEN)) for _ in range(6)
    ]
    assert (np.mean(shares) > 0.5) == more_than_half


def explained_by_best(angle, error, count):
    """Return the share of the squares of errors ``(n,)`` at joint angles ``(n,)`` [rad] that ``count`` orders, chosen one by one, explain."""
    chosen = np.ones((len(angle), 1))
    total = np.sum((error - error.mean()) ** 2)
    left = set(range(1, 33))
    for _ in range(count):
        fits = {k: np.column_stack([chosen, np.sin(k * angle), np.cos(k * angle)]) for k in left}
        squares = {
            k: np.sum((error - A @ np.linalg.lstsq(A, error, rcond=None)[0]) ** 2) for k, A in fits.items()
        }
        best = min(squares, key=lambda k: squares[k])
        chosen, rest = fits[best], squares[best]
        left.remove(best)
    return 1.0 - rest / total
