"""Lower the confidence in names that rest on the order of the poses if the table was imported and nobody stated its order.

Without a column ``order`` or ``time`` the rows of poses.csv are in the order of acquisition, by the format of datasets. A table that is imported
may be in another order: sorted, or averaged over several runs. If its mapping states no order, the import records that (``Dataset.imported``). An
error that depends on the column by which a table was sorted follows the rows, as a drift does: from a table of a FANUC's poses, each the mean of ten
readings and not in the order of acquisition, the diagnosis named a thermal drift with a confidence of 1.00.
"""

from __future__ import annotations

from collections.abc import Sequence

from scalar.data.dataset import Dataset
from scalar.data.formats import NOT_STATED
from scalar.diagnosis.naming.finding import Finding, limited_where
from scalar.diagnosis.naming.most_confidence import ONE_OF_TWO
from scalar.effects import Effect
from scalar.estimation.setup.suspicion import Suspicion

NOT_KNOWN = "nothing stated the order of the poses when they were imported, and a table in another order imitates what follows the order"
ORDER = "order"  # as a suspicion names an order that was assumed


def order_is_stated(dataset: Dataset) -> bool:
    """Return whether the order in which the poses were measured is known: by a column, or by the format of datasets that were not imported."""
    return bool({"order", "time"} & {*dataset.poses.columns}) or dataset.imported.get("order") != NOT_STATED


def rests_on_order(effect: Effect, dataset: Dataset) -> bool:
    """Return whether an effect is known by the order of the poses alone; recorded directions of approach, for example, tell play without it."""
    recorded = ({*effect.moves_from} - {"order"}) & {*dataset.poses.columns}
    return effect.follows_order and not recorded


def limited_by_order(
    found: Sequence[Finding], dataset: Dataset, least_confidence: float
) -> tuple[Finding, ...]:
    """Return the findings, with the confidence limited in each name that rests on an order of the poses that nothing stated.

    Args:
        found: All findings.
        dataset: What was measured.
        least_confidence: A name with less confidence is doubtful.
    """
    if order_is_stated(dataset):
        return tuple(found)
    return limited_where(
        found,
        lambda f: rests_on_order(f.effect, dataset) and not f.effect.flexible,
        ONE_OF_TWO,
        least_confidence,
        NOT_KNOWN,
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
        "something was found that follows the order of the poses, and nothing stated this order when the tables were imported: that of the rows is "
        f"assumed, and a table that was sorted or averaged imitates a drift or a slip. No such name has a confidence of more than "
        f"{100 * ONE_OF_TWO:.0f} %. If the rows are in the order of acquisition, write rows_in_order: true under poses in the mapping, import "
        "again, and diagnose again"
    )
    return [Suspicion(ORDER, "poses.csv", sentence)]
