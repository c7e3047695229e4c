"""The candidate set: what is tried on a dataset, by all kinds of effects that the registry knows."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scalar.effects import Effect, registry
from scalar.effects.flexible.proposals import flexible_terms

if TYPE_CHECKING:
    import numpy as np

    from scalar.data.dataset import Dataset


def candidates(dataset: Dataset) -> list[Effect]:
    """Return the effects with a name that can be tried; those that may set in at any pose are tried apart (``changes``)."""
    return [effect for kind in registry.known().values() for effect in kind.candidates(dataset)]


def changes(dataset: Dataset) -> list[tuple[Effect, np.ndarray]]:
    """Return effects that may set in at any pose: each as it acts all the time, and the poses ``(N,)`` bool that it touches."""
    return [change for kind in registry.known().values() for change in kind.changes(dataset)]


def flexible(dataset: Dataset) -> list[Effect]:
    """Return the flexible terms that are tried on structure that the named effects leave."""
    return flexible_terms(dataset)


def elements(effect: Effect) -> list[Effect]:
    """Return the effects of one term each that stand, one after the other, for all columns of an effect."""
    return [effect] if effect.n_terms == 1 else [effect.with_terms([i]) for i in range(effect.n_terms)]
