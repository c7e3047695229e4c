"""Whether a recording fits another reading of the set-up far better than the description, and which; the user has to correct it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from scalar.ingest.bag.placement import NO_PLANE, Placement
from scalar.ingest.bag.readings import Reading, other_readings, readings_with_any_zero
from scalar.ingest.bag.straight_scans import Pieces
from scalar.units import DEG, MM

CLEARLY_BETTER = 20.0
"""By how much the cost of another reading has to be lower [nats]: its posterior probability is then higher by a factor of 5e8. Chosen."""
_AS_GOOD = 5.0  # chosen, nats: two readings whose costs differ by less are not distinguished
_CLOSE = 20 * MM  # chosen: a scan this near to a plane may lie on it, given the errors of a nominal arm
# Share of the scans that have to lie on planes under another reading: a few scans were taken between the planes.
_ENOUGH = 0.8
# Of the scans that lie on no plane as described, the largest share that may lie on none under another reading either.
_STILL_LOST = 1.0 / 3.0
_FEW_LOST = 0.1  # share of the scans up to which scans on no plane alone suggest no other reading
_FALLS_BY = 3.0  # factor by which the median distance falls under a reading that explains the scans
# The scanner is turned from its stated pose by more than the first as described, and by less than the second under a reading that explains this.
_TURNED, _NEARLY = 45 * DEG, 30 * DEG


@dataclass(frozen=True)
class BetterReading:
    """Other readings of the set-up under which a recording fits far better.

    Attributes:
        as_described: A clause on how badly the scans fit the description.
        sentences: One for each reading; several are not distinguished by the recording.
    """

    as_described: str
    sentences: tuple[str, ...]


def better_reading(
    pieces: Pieces,
    names: Sequence[str],
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> BetterReading | None:
    """Return the other readings that explain the recording far better than the description; None if none does.

    Scanner and planes are fitted under each reading, and the scans assigned to the planes anew.

    Args:
        pieces: The straight pieces of the recording.
        names: Names of the recorded joints in the assumed order.
        progress: Called with the number of readings that were tried, and the number of all.
    """
    least_possible = -len(pieces.q) * np.log1p(np.exp(-0.5 * NO_PLANE**2))
    if pieces.placement.cost - least_possible < CLEARLY_BETTER:
        return None
    tried = other_readings(pieces, names)
    for done, reading in enumerate(tried):
        progress(done, len(tried))
        _ = reading.cost
    progress(0, 0)
    likely = _likely(tried, pieces) or _likely(list(readings_with_any_zero(pieces, names)), pieces)
    if not likely:
        return None
    sentences = tuple(_in_words(reading, pieces, len(likely)) for reading in likely)
    return BetterReading(_as_described(pieces, likely[0]), sentences)


def _likely(tried: Sequence[Reading], described: Pieces) -> list[Reading]:
    """Return the most probable of some readings, and those that are about as probable, as far as they explain the recording far better."""
    least = min((reading.cost for reading in tried), default=np.inf)
    if least > described.placement.cost - CLEARLY_BETTER:
        return []
    return [
        reading for reading in tried if reading.cost <= least + _AS_GOOD and _explains(reading, described)
    ]


def _explains(reading: Reading, described: Pieces) -> bool:
    """Return whether nearly all scans lie on planes under a reading, and clearly more or nearer than as described, or with the scanner as stated."""
    total, lost, lost_before = len(described.q), _lost(reading.pieces), _lost(described)
    if lost > (1.0 - _ENOUGH) * total:
        return False
    return (
        (lost_before > _FEW_LOST * total and lost <= _STILL_LOST * lost_before)
        or _FALLS_BY * reading.pieces.labels.typical <= described.labels.typical
        or _turned_less(reading.pieces.placement, described.placement)
    )


def _turned_less(placement: Placement, described: Placement) -> bool:
    """Return whether the scanner sits nearly as it is stated at a placement, and far otherwise at that of the set-up as described."""
    return described.turn > _TURNED and placement.turn < _NEARLY


def _lost(pieces: Pieces) -> int:
    """Return how many scans are not close to any plane."""
    return int(np.count_nonzero(pieces.labels.nearest > _CLOSE))


def _as_described(pieces: Pieces, reading: Reading) -> str:
    """Return the clause on how badly the scans fit the description, compared with one of the other readings."""
    if _turned_less(reading.pieces.placement, pieces.placement) and _lost(pieces) <= _FEW_LOST * len(
        pieces.q
    ):
        return (
            f"the scans fit the set-up as described only with the scanner turned by {pieces.placement.turn / DEG:.0f} degrees from "
            "sensor.nominal_pose"
        )
    return (
        f"the scans do not fit the set-up as described: {_lost(pieces)} of {len(pieces.q)} lie {_CLOSE / MM:.0f} mm or more from every plane, "
        "wherever scanner and planes are near their guesses"
    )


def _in_words(reading: Reading, described: Pieces, one_of: int) -> str:
    """Return the sentence on a reading that explains the recording, one of so many."""
    labels = reading.pieces.labels
    figures = f"half of the scans then lie within {_in_mm(labels.typical)} mm of their planes"
    if described.labels.typical >= _FALLS_BY * labels.typical:
        figures += f", and as described within {_in_mm(described.labels.typical)} mm"
    if (turn := reading.pieces.placement.turn) > _TURNED:
        figures += f"; the scanner is then turned by {turn / DEG:.0f} degrees from sensor.nominal_pose, which may be a second mistake"
    open_ = "" if one_of == 1 else f"one of {one_of}, which this recording does not distinguish: "
    return f"{open_}{labels.count} of {len(labels.index)} scans would lie on a plane with {reading.what}{reading.remedy}; {figures}"


def _in_mm(length: float) -> str:
    return f"{length / MM:.2g}" if length < 100 * MM else f"{length / MM:.0f}"
