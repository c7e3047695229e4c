"""Choose poses by what they are expected to give: the error of predicted positions in the workspace, before anything is measured.

The expectation is that of the estimator's own linearisation, at the nominal arm or near a calibration: noise of the sensor, repeatability of the
arm, nothing that the model lacks.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from scalar.planning.exchange import Design, add_best, exchange
from scalar.planning.information import Information
from scalar.units import MM

FORMAT = "scalar-plan/1"
CRITERIA = ("error", "determinant")
_RANDOM_DRAWS = 20
_EQUATIONS_TO_SPARE = 1.3  # a plan has at least so many independent equations for each free parameter
_LEAST_OF_EACH = (
    0.5  # of an equal share: the least that each plane has, so that a fit finds its way from rough guesses
)
_STARTS = 3  # sets from which exchanges begin: the greedy one, and random ones
_MOST = 400  # poses that are considered for a wanted accuracy


@dataclass(frozen=True, eq=False)
class Plan:
    """Chosen poses and what they are expected to give.

    Attributes:
        chosen: ``(k,)``, indices of candidates.
        error: Of a predicted position [m], root mean square over the workspace.
        random_error: The same for as many candidates chosen at random, the mean over some draws [m].
        curve: ``(n, 2)``: number of poses and error [m], for plans of other sizes.
        exchanges: How many exchanges improved the set.
    """

    chosen: list[int]
    error: float
    random_error: float
    curve: list[tuple[int, float]]
    exchanges: int

    def to_mapping(self) -> dict[str, Any]:
        """Return the numbers as ``plan.json`` has them."""
        return {
            "poses": len(self.chosen),
            "expected_error_mm": self.error / MM,
            "expected_error_of_random_poses_mm": self.random_error / MM,
            "exchanges": self.exchanges,
            "by_number_of_poses": [{"poses": n, "expected_error_mm": e / MM} for n, e in self.curve],
        }


def least_poses(info: Information, equations_per_pose: int) -> int:
    """Return the fewest poses that a plan should have."""
    return int(np.ceil(_EQUATIONS_TO_SPARE * len(info.free) / equations_per_pose))


def choose_poses(
    info: Information, count: int, criterion: str, rng: np.random.Generator, sizes: tuple[int, ...] = ()
) -> Plan:
    """Return a plan of some number of poses.

    Args:
        info: Of the candidates.
        count: How many.
        criterion: ``error``, the predicted error in the workspace (A), or ``determinant`` (D).
        rng: Draws the sets of random poses that the plan is compared with.
        sizes: Numbers of poses for the curve.
    """
    design, exchanges = designed(info, count, criterion, rng)
    at_random = [_error_of(info, _at_random(info, count, rng)) for _ in range(_RANDOM_DRAWS)]
    error = info.error(design.covariance)
    curve = [(n, e) for n, e in greedy_errors(info, max((*sizes, 0))) if n in sizes and n != count]
    return Plan(
        list(design.chosen), error, float(np.mean(at_random)), sorted([*curve, (count, error)]), exchanges
    )


def poses_for_error(info: Information, wanted: float, least: int, criterion: str) -> int | None:
    """Return how many poses a wanted error [m] takes, or None where as many as are considered do not give it."""
    most = min(len(info.rows), _MOST)
    enough = next((n for n, e in greedy_errors(info, most) if n >= least and e <= wanted), None)
    if enough is None:
        return None
    low, high = least - 1, enough  # the exchange may do with fewer than one pose after the other
    while high - low > 1:
        middle = (low + high) // 2
        design, _ = designed(info, middle, criterion, np.random.default_rng(0))
        low, high = (low, middle) if info.error(design.covariance) <= wanted else (middle, high)
    return high


def greedy_errors(info: Information, most: int) -> list[tuple[int, float]]:
    """Return the expected error after each pose that is added, each the best one given those before."""
    design = _begun(info, 0, CRITERIA[0])
    errors = []
    for k in range(min(most, len(info.rows))):
        design.least = _least_of_each(info, k + 1)
        add_best(design, 1)
        errors.append((len(design.chosen), info.error(design.covariance)))
    return errors


def designed(info: Information, count: int, criterion: str, rng: np.random.Generator) -> tuple[Design, int]:
    """Return the best set that exchanges end at from a few starts, and how many exchanges led there."""
    found = []
    for k in range(_STARTS):
        design = _begun(info, count, criterion)
        if k:
            design.chosen = _at_random(info, count, rng)
            design.refresh()
        else:
            add_best(design, count)
        exchanges = exchange(design)
        found.append((design, exchanges))
    return min(found, key=lambda each: each[0].value)


def _begun(info: Information, count: int, criterion: str) -> Design:
    interest = info.interest if criterion == CRITERIA[0] else None
    return Design.of(info.rows, info.start, interest, [], info.items, _least_of_each(info, count))


def _least_of_each(info: Information, count: int) -> int:
    return int(_LEAST_OF_EACH * count / len(np.unique(info.items)))


def _at_random(info: Information, count: int, rng: np.random.Generator) -> list[int]:
    """Return candidates drawn at random, as many of each item of the target."""
    order = rng.permutation(len(info.rows))
    rank = np.zeros(len(order))
    for item in np.unique(info.items):
        own = info.items[order] == item
        rank[own] = np.arange(own.sum())
    return [int(i) for i in order[np.argsort(rank, kind="stable")][:count]]


def _error_of(info: Information, chosen: list[int]) -> float:
    return info.error(Design.of(info.rows, info.start, info.interest, chosen).covariance)
