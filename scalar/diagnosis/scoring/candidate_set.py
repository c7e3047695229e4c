"""The candidates for a dataset: the effects that every known kind proposes for it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scalar.effects import Effect, registry
from scalar.effects.flexible.proposals import flexible_terms

if TYPE_CHECKING:
    import numpy as np

    from scalar.data.dataset import Dataset


def candidates(dataset: Dataset) -> list[Effect]:
    """Return the named effects that are candidates for a dataset, without those that may begin at any pose (``changes``)."""
    return [effect for kind in registry.known().values() for effect in kind.candidates(dataset)]


def changes(dataset: Dataset) -> list[tuple[Effect, np.ndarray]]:
    """Return the effects that may begin at any pose: each as if it acted all the time, and ``(N,)`` bool, the poses that it touches."""
    return [change for kind in registry.known().values() for change in kind.changes(dataset)]


def of_common_causes(dataset: Dataset) -> list[list[Effect]]:
    """Return the groups of named effects that one cause brings about together."""
    return [group for kind in registry.known().values() for group in kind.together(dataset)]


def flexible(dataset: Dataset) -> list[Effect]:
    """Return the flexible terms that are candidates for structure that the named effects leave."""
    return flexible_terms(dataset)


def elements(effect: Effect) -> list[Effect]:
    """Return effects of one term each; their columns, one after the other, are those of the given effect."""
    return [effect] if effect.n_terms == 1 else [effect.with_terms([i]) for i in range(effect.n_terms)]
