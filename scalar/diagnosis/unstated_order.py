"""Lower the confidence in names that rest on the order of the poses where nobody stated it.

Without a column ``order`` or ``time`` the rows of poses.csv stand for the order of acquisition. That is right for a log, and wrong for a table that
was sorted, or averaged over several runs. An error that depends on the column by which a table was sorted then follows the rows, as a drift does: the
means of ten readings of a FANUC, in another order than that of acquisition, had given a thermal drift with a confidence of 1.00.
"""

from __future__ import annotations

from collections.abc import Sequence

from scalar.data.dataset import Dataset
from scalar.diagnosis.finding import Finding
from scalar.effects import Effect
from scalar.estimation.setup.suspicion import Suspicion

MOST_CONFIDENCE = 0.5  # chosen: the cause is the effect or the order of the table
ORDER = "order"  # as a suspicion names an order that was assumed


def order_is_stated(dataset: Dataset) -> bool:
    """Return whether a column of poses.csv says in which order the poses were measured."""
    return bool({"order", "time"} & {*dataset.poses.columns})


def rests_on_order(effect: Effect, dataset: Dataset) -> bool:
    """Return whether an effect is known by the order of the poses alone; recorded directions of approach, for example, tell play without it."""
    recorded = ({*effect.moves_from} - {"order"}) & {*dataset.poses.columns}
    return effect.follows_order and not recorded


def limited_by_order(
    found: Sequence[Finding], dataset: Dataset, least_confidence: float
) -> tuple[Finding, ...]:
    """Return the findings, with the confidence limited in each name that rests on an order of the poses that no column states.

    Args:
        found: All findings.
        dataset: What was measured.
        least_confidence: A name with less confidence is doubtful.
    """
    if order_is_stated(dataset):
        return tuple(found)
    return tuple(
        f.limited(MOST_CONFIDENCE, least_confidence)
        if rests_on_order(f.effect, dataset) and not f.effect.flexible
        else f
        for f in found
    )


def unstated_order(dataset: Dataset, effects: Sequence[Effect]) -> list[Suspicion]:
    """Return the suspicion that the rows are not in the order of acquisition, if something that was found rests on it; else none.

    Args:
        dataset: What was measured.
        effects: What was found, terms without a name included.
    """
    if order_is_stated(dataset) or not any(rests_on_order(effect, dataset) for effect in effects):
        return []
    sentence = (
        "something was found that follows the order of the poses, and no column of poses.csv states this order: that of the rows is assumed, and a "
        f"table that was sorted or averaged imitates a drift or a slip. No such name has a confidence of more than {100 * MOST_CONFIDENCE:.0f} %. If "
        "the rows are in the order of acquisition, add a column order that counts them (where 'scalar import' made the tables, rows_in_order: true "
        "under poses in the mapping), and diagnose again"
    )
    return [Suspicion(ORDER, "poses.csv", sentence)]
