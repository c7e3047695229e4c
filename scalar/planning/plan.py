"""Choose poses by the error of predicted positions in the workspace that a calibration from them is expected to have.

The expected error comes from the estimator's linearisation at the nominal arm or at an earlier calibration. It contains the noise of the
sensor and the repeatability of the arm, but no errors that the model does not describe.
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
_EQUATIONS_TO_SPARE = 1.3  # independent equations that a plan has at least for each free parameter
# Each plane gets at least this part of an equal share of the poses, so that a fit converges from rough guesses of the planes.
_LEAST_OF_EACH = 0.5
_STARTS = 3  # sets from which exchanges begin: the greedy one (poses added one by one, each the best), and random ones
_MOST = 400  # the most poses that are considered for a wanted accuracy


@dataclass(frozen=True, eq=False)
class Plan:
    """Chosen poses and the error that they are expected to leave.

    Attributes:
        chosen: ``(k,)``, indices of candidates.
        error: Expected error of a predicted position [m], root mean square over the workspace.
        random_error: The same for as many candidates chosen at random, the mean over some draws [m].
        curve: Pairs of number of poses and expected error [m], of this plan and of plans of other sizes. The latter are upper bounds, since they
            are computed without exchanges.
        exchanges: How many exchanges improved the set.
    """

    chosen: list[int]
    error: float
    random_error: float
    curve: list[tuple[int, float]]
    exchanges: int

    def to_mapping(self) -> dict[str, Any]:
        """Return the numbers that ``plan.json`` has."""
        return {
            "poses": len(self.chosen),
            "expected_error_mm": self.error / MM,
            "expected_error_of_random_poses_mm": self.random_error / MM,
            "exchanges": self.exchanges,
            "by_number_of_poses": [{"poses": n, "expected_error_mm": e / MM} for n, e in self.curve],
        }


def least_poses(info: Information, equations_per_pose: int) -> int:
    """Return the fewest poses that a plan may have, so that their equations determine the free parameters, with those of measured poses if any."""
    needed = int(np.ceil(_EQUATIONS_TO_SPARE * len(info.free) / equations_per_pose))
    if not info.measured:
        return needed
    own = int(np.ceil(_EQUATIONS_TO_SPARE * (len(info.free) - info.shared) / equations_per_pose))
    return max(1, own, needed - info.measured)


def choose_poses(
    info: Information, count: int, criterion: str, rng: np.random.Generator, sizes: tuple[int, ...] = ()
) -> Plan:
    """Return a plan of ``count`` poses.

    Args:
        info: The information of the candidates.
        count: Number of poses.
        criterion: ``error``, the predicted error in the workspace (A), or ``determinant`` (D).
        rng: Draws random sets: some from which exchanges begin, and those with which the plan is compared.
        sizes: Numbers of poses for the curve.
    """
    design, exchanges = best_design(info, count, criterion, rng)
    at_random = [error_of(info, _at_random(info, count, rng)) for _ in range(_RANDOM_DRAWS)]
    error = info.error(design.covariance)
    greedy = [(n, e) for n, e in greedy_errors(info, max((*sizes, 0))) if n in sizes and n != count]
    # Further poses can only lower the error of this plan.
    curve = [(n, min(e, error) if n > count else e) for n, e in greedy]
    return Plan(
        list(design.chosen), error, float(np.mean(at_random)), sorted([*curve, (count, error)]), exchanges
    )


def poses_for_error(
    info: Information, wanted: float, least: int, criterion: str
) -> tuple[int | None, tuple[int, float]]:
    """Return the number of poses that a wanted error requires, or None if even the most that are considered (400) do not reach it.

    The second value is the most poses that are considered, and the error [m] that is expected of them.

    Args:
        info: The information of the candidates.
        wanted: The error [m], root mean square over the workspace.
        least: The fewest poses that a plan may have.
        criterion: As in ``choose_poses``.
    """
    most = min(len(info.rows), _MOST)
    errors = greedy_errors(info, most)
    enough = next((n for n, e in errors if n >= least and e <= wanted), None)
    if enough is None:
        return None, errors[-1]
    low, high = least - 1, enough  # exchanges may need fewer poses than adding one after the other
    while high - low > 1:
        middle = (low + high) // 2
        design, _ = best_design(info, middle, criterion, np.random.default_rng(0))
        low, high = (low, middle) if info.error(design.covariance) <= wanted else (middle, high)
    return high, errors[-1]


def greedy_errors(info: Information, most: int) -> list[tuple[int, float]]:
    """Return pairs of number of poses and expected error [m] as poses are added one by one, each the best one given those before."""
    design = _empty_design(info, 0, CRITERIA[0])
    errors = []
    for k in range(min(most, len(info.rows))):
        design.least = _least_of_each(info, k + 1)
        add_best(design, 1)
        errors.append((len(design.chosen), info.error(design.covariance)))
    return errors


def best_design(
    info: Information, count: int, criterion: str, rng: np.random.Generator
) -> tuple[Design, int]:
    """Return the best of the sets of poses to which exchanges lead from a few initial sets, and the number of exchanges that led to it.

    Args:
        info: The information of the candidates.
        count: Number of poses.
        criterion: As in ``choose_poses``.
        rng: Draws the initial sets after the first, which is greedy.
    """
    found = []
    for k in range(_STARTS):
        design = _empty_design(info, count, criterion)
        if k:
            design.chosen = _at_random(info, count, rng)
            design.refresh()
        else:
            add_best(design, count)
        exchanges = exchange(design)
        found.append((design, exchanges))
    return min(found, key=lambda each: each[0].value)


def _empty_design(info: Information, count: int, criterion: str) -> Design:
    """Return a design without any candidate, which is to get ``count`` of them."""
    interest = info.interest if criterion == CRITERIA[0] else None
    return Design.of(info.rows, info.start, interest, [], info.items, _least_of_each(info, count))


def _least_of_each(info: Information, count: int) -> int:
    """Return how many of ``count`` poses each item of the target gets at least."""
    return int(_LEAST_OF_EACH * count / len(np.unique(info.items)))


def _at_random(info: Information, count: int, rng: np.random.Generator) -> list[int]:
    """Return candidates drawn at random, equally many of each item of the target."""
    order = rng.permutation(len(info.rows))
    rank = np.zeros(len(order))
    for item in np.unique(info.items):
        own = info.items[order] == item
        rank[own] = np.arange(own.sum())
    return [int(i) for i in order[np.argsort(rank, kind="stable")][:count]]


def error_of(info: Information, chosen: list[int]) -> float:
    """Return the expected error [m] of a set of candidates."""
    return info.error(Design.of(info.rows, info.start, info.interest, chosen).covariance)
