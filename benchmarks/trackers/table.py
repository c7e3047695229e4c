"""The table of the benchmark: one line for each way, over all scenes of a kind."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from benchmarks.trackers.contest import Outcome, Score
from benchmarks.trackers.environments import Missing
from scalar.units import MM

HEADER = (
    "way",
    "version",
    "error [mm RMS]",
    "least to most",
    "largest [mm]",
    "first fit [s]",
    "again [s]",
    "takes",
    "fitted",
    "standard errors",
)


def row(title: str, outcomes: Sequence[Outcome | Missing]) -> tuple[str, ...]:
    """Return the cells of a way: medians over the scenes that it answered, and why it did not answer the others."""
    found = [each for each in outcomes if isinstance(each, Outcome)]
    reasons = sorted({each.reason for each in outcomes if isinstance(each, Missing)})
    if not found:
        return (title, "; ".join(reasons))
    answers = [each.answer for each in found]
    first, again = (np.median([answer.seconds[i] for answer in answers]) for i in (0, -1))
    name = title if not reasons else f"{title} ({len(found)} of {len(outcomes)} scenes; {'; '.join(reasons)})"
    return (
        name,
        answers[0].version,
        *errors([each.score for each in found]),
        f"{first:.3f}",
        f"{again:.3f}",
        _range([answer.evaluations for answer in answers], answers[0].counted),
        _range([answer.parameters for answer in answers]),
        answers[0].standard_errors,
    )


def errors(scores: Sequence[Score]) -> tuple[str, str, str]:
    """Return the median error of scenes, its range, and the largest error at a pose, all in mm."""
    rms = np.array([each.rms for each in scores]) / MM
    largest = max(each.largest for each in scores) / MM
    return f"{np.median(rms):.4f}", f"{rms.min():.4f} to {rms.max():.4f}", f"{largest:.3f}"


def _range(counts: Sequence[int | None], counted: str = "") -> str:
    """Return the least and the greatest of some counts, with what is counted; nothing if one is unknown."""
    known = [count for count in counts if count is not None]
    if len(known) < len(counts):
        return ""
    least, most = min(known), max(known)
    return f"{least if least == most else f'{least} to {most}'} {counted}".strip()


def table(rows: Sequence[Sequence[str]]) -> str:
    """Return rows as a table in Markdown; a row with fewer cells is filled up with empty ones."""
    filled = [(*cells, *[""] * (len(HEADER) - len(cells))) for cells in rows]
    lines = [HEADER, ("---",) * 2 + ("---:",) * 6 + ("---:", "---"), *filled]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in lines)
