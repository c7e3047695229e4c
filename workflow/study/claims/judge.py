"""Judge every claim of the original paper on the results of a run, by stated rules; no verdict is written by hand.

A claim is a row of ``judged_claims.csv``: its number, the section that makes it, the table that answers it and the rule by which it is judged. The
values found are medians over the seeds with their band, the 5 and 95 % quantiles. Errors are raw (the base is not aligned), and walls are upright.
There is a row for each *way* to calibrate: a method, or an order of steps. The rules:

- ``reached``: an accuracy. It is confirmed if it lies in the band; it *differs* if the whole band is better; else it does not hold.
- ``draw``, ``value``: a number of one run. It is confirmed if it lies within the range of the seeds. Else it differs, but a ``value`` does not hold
  if the median is more than ``FAR`` times larger or smaller.
- ``enough``: more data change nothing. It is confirmed if the error is at most ``SAME`` times that with more data, does not hold from ``CHANGED``
  times on, and differs in between.
- ``unaffected``: a change does no harm. It is judged like ``enough`` by the factor by which the error becomes larger or smaller; it does not hold if
  less than the share ``MOST`` of the fits succeeds, and at best differs if any fit fails.
- ``within``, ``fails``, ``at_once``: a share of the seeds. It is confirmed from ``MOST`` on, does not hold below one half, and differs in between;
  ``at_once`` also differs if a case other than the first has a share below ``MOST``.
- ``count``: it is confirmed if the numbers are equal, else it does not hold.
- ``duration``: it is confirmed if a fit takes less time, else it does not hold; without a measured time it is ``ABSENT``.

A fit that failed confirms nothing: if less than the share ``MOST`` of the fits succeeds, ``reached``, ``value`` and ``enough`` differ at best; a seed
without a calibration has no plane within its limits; and ``fails`` is confirmed only if fits succeed with enough data.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pandas as pd

from study.common.methods import INITIAL, METHODS

CONFIRMED, DIFFERS, FAILS = "confirmed", "differs", "does not hold"
ABSENT = "not in this run"
WALLS = "upright"
SAME, CHANGED = 1.10, 1.25  # ratios of errors up to which they count as equal, and from which on as different
MOST = 0.95  # share of the seeds from which on a claim holds for them
FAR = 2.0  # ratio from which on a value contradicts the published one
CLAIM_COLUMNS = {
    "claim": "name of the claim",
    "statement": "the claim in the words of this project; `unit` has the unit of its numbers",
    "where": "section of the original paper",
    "published": "the original paper's number",
    "unit": "unit of the numbers",
    "way": "way to calibrate; empty if the claim does not depend on it",
    "found": "median over the seeds, or the share or ratio that the statement names",
    "low": "5 % quantile over the seeds; for the rule at_once, the least share over all cases",
    "high": "95 % quantile over the seeds",
    "seeds": "number of seeds",
    "verdict": f"{CONFIRMED}, {DIFFERS}, {FAILS}, or {ABSENT}",
    "why": "the reason of the verdict",
}


@dataclass(frozen=True)
class Results:
    """The tables that answer claims; one that a run lacks is None or missing.

    Attributes:
        headline: summary.csv of the main study.
        planes: planes.csv.
        singular_values: singular_values.csv.
        sequential: summary.csv of the comparison with sequential calibration.
        sweeps: ``{name of a sweep: its summary.csv}``.
        seconds: ``{way to calibrate: wall time of a whole calibration [s]}``.
    """

    headline: Any = None
    planes: Any = None
    singular_values: Any = None
    sequential: Any = None
    sweeps: Mapping[str, Any] = field(default_factory=dict)
    seconds: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Found:
    """What one way to calibrate found for a claim; numbers are in the claim's unit, and NaN if they do not apply.

    Attributes:
        way: Way to calibrate; empty if the claim does not depend on it.
        value: Median over the seeds, or the share, ratio or count that the rule judges.
        low: Lower end of the band, the 5 % quantile over the seeds; for ``at_once``, the least share over all cases.
        high: Upper end of the band, the 95 % quantile.
        least: Smallest value of a seed.
        most: Largest value of a seed.
        seeds: Number of seeds.
        succeeded: Share of the fits that succeeded.
    """

    way: str
    value: float
    low: float = np.nan
    high: float = np.nan
    least: float = np.nan
    most: float = np.nan
    seeds: int = 0
    succeeded: float = 1.0


def judge(rule: str, published: float, found: Found) -> tuple[str, str]:
    """Return the verdict of a rule on what one way found, and the reason.

    Args:
        rule: Name of a rule, as the module's docstring lists them.
        published: The original paper's number.
        found: What this way found.
    """
    verdict, why = _judge(rule, published, found)
    if verdict == CONFIRMED and rule in ("reached", "value", "enough", "fails") and found.succeeded < MOST:
        where = "with enough data " if rule == "fails" else ""
        return DIFFERS, f"{why}, but {where}only {_percent(found.succeeded)} of the fits succeed"
    return verdict, why


def _judge(rule: str, published: float, found: Found) -> tuple[str, str]:
    """Return the verdict and the reason as ``judge`` does, without regard to failed fits in the rules that share this."""
    if rule == "count":
        same = found.value == published
        return (CONFIRMED, "the same count") if same else (FAILS, f"we count {found.value:g}")
    if rule == "duration" and not 0 < found.value < np.inf:
        return ABSENT, "no time was measured"
    if (
        rule == "duration"
    ):  # no time is stated, so that the table is the same on every machine that is fast enough
        return (
            (CONFIRMED, "timed: a fit takes less")
            if found.value < published
            else (FAILS, "timed: a fit takes longer")
        )
    if rule in ("within", "fails", "at_once"):
        share = f"{_percent(found.value)} of the seeds"
        return _by_share(found.value), share
    if not np.isfinite(found.value):
        return FAILS, "no fit converged"
    if rule == "enough":
        return _by_ratio(found.value, f"the error is {found.value:.2f} times that with more data")
    if rule == "unaffected":
        if found.succeeded < MOST:
            return FAILS, f"{_percent(found.succeeded)} of the fits succeed"
        verdict, why = _by_ratio(max(found.value, 1 / found.value), f"the error is {found.value:.2f} times")
        return (DIFFERS if found.succeeded < 1 and verdict == CONFIRMED else verdict), why
    times = found.value / published
    if rule == "reached":
        if found.low <= published <= found.high:
            return CONFIRMED, "within 5 to 95 % of our seeds"
        if found.high < published:
            return DIFFERS, f"we come {1 / times:.2g} times nearer to the truth"
        return FAILS, f"the error is {times:.2g} times as large"
    if found.least <= published <= found.most:
        return CONFIRMED, "within the range of our seeds"
    far = rule == "value" and not 1 / FAR <= times <= FAR
    return (
        FAILS if far else DIFFERS
    ), f"outside the range of our seeds, whose median is {times:.2g} times as large"


def _percent(share: float) -> str:
    return f"{100 * share:.0f} %"


def _by_share(share: float) -> str:
    """Return the verdict on a share of the seeds."""
    return CONFIRMED if share >= MOST else DIFFERS if share >= 0.5 else FAILS


def _by_ratio(ratio: float, why: str) -> tuple[str, str]:
    """Return the verdict on a ratio of errors, with the given reason."""
    return (CONFIRMED if ratio <= SAME else FAILS if ratio >= CHANGED else DIFFERS), why


def judge_claims(published: pd.DataFrame, results: Results) -> pd.DataFrame:
    """Return a row for each claim and way, columns ``CLAIM_COLUMNS``.

    Args:
        published: Content of judged_claims.csv.
        results: The tables of the run.
    """
    rows: list[dict[str, Any]] = []
    for claim in published.to_dict("records"):
        stem = {name: claim[name] for name in ("claim", "statement", "where", "published")}
        stem["unit"] = "" if pd.isna(claim["unit"]) else claim["unit"]
        answers = answers_of(claim, results)
        for found in answers:
            verdict, why = judge(claim["rule"], float(claim["published"]), found)
            if claim["rule"] == "at_once" and verdict == CONFIRMED and found.low < MOST:
                verdict, why = DIFFERS, f"{why}, but {_percent(found.low)} in the case that suits it least"
            value = np.nan if claim["rule"] == "duration" else found.value
            band = {"found": value, "low": found.low, "high": found.high, "seeds": found.seeds}
            rows.append(stem | {"way": found.way} | band | {"verdict": verdict, "why": why})
        if not answers:
            rows.append(
                stem | {"way": "", "seeds": 0, "verdict": ABSENT, "why": "no table of this run answers it"}
            )
    return pd.DataFrame(rows).reindex(columns=list(CLAIM_COLUMNS))


def answers_of(claim: Mapping[str, Any], results: Results) -> list[Found]:
    """Return what each way to calibrate found for a claim; an empty list if the run has no such table or point."""
    source = str(claim["source"])
    if source == "headline" and results.headline is not None:
        return _of_headline(claim, results.headline)
    if source == "planes" and results.planes is not None:
        return _of_planes(claim, results.planes)
    if source == "singular_values" and results.singular_values is not None:
        null = results.singular_values["null"]
        return [Found("", float(null.sum()) if claim["quantity"] == "zero" else float(len(null)), seeds=1)]
    if source == "sequential" and results.sequential is not None:
        return _of_sequential(claim, results.sequential)
    if source == "benchmark":
        return [Found(way, seconds) for way, seconds in results.seconds.items()]
    name = source.removeprefix("sweep:")
    return _of_sweep(claim, results.sweeps[name]) if name in results.sweeps else []


def _of_headline(claim: Mapping[str, Any], summary: Any) -> list[Found]:
    rows = summary[(summary["alignment"] == "raw") & (summary["quantity"] == claim["quantity"])]
    rows = rows[(rows["method"] == INITIAL) == (claim["rule"] == "draw")]
    return [
        _over_seeds("" if row["method"] == INITIAL else row["method"], row) for row in rows.to_dict("records")
    ]


def _over_seeds(way: str, row: Mapping[str, Any]) -> Found:
    """Return what a row of a summary states for a claim: median, band, range, seeds and the share of fits that succeeded."""
    failed = row.get("not_converged", row.get("failed", 0) + row.get("lost", 0))
    seeds, succeeded = int(row["seeds"]), 1 - failed / row["seeds"]
    return Found(way, row["median"], row["p05"], row["p95"], row["min"], row["max"], seeds, succeeded)


def _of_planes(claim: Mapping[str, Any], planes: Any) -> list[Found]:
    """Return the share of seeds in which the error of every plane lies within the claimed limit; a seed without a calibration counts as outside."""
    rows = planes[planes["method"] != INITIAL]
    seeds = planes["seed"].unique()
    inside = rows[claim["quantity"]].abs() <= float(claim["published"])
    found = []
    for way, of_way in inside.groupby(rows["method"], sort=False):
        whole = of_way.groupby(rows["seed"]).all().reindex(seeds, fill_value=False)
        found.append(Found(str(way), float(whole.mean()), seeds=len(whole)))
    return found


def _of_sweep(claim: Mapping[str, Any], summary: Any) -> list[Found]:
    rows = summary[
        (summary["walls"] == WALLS)
        & (summary["alignment"] == "raw")
        & (summary["quantity"] == claim["quantity"])
        & summary["method"].isin(METHODS)
    ]
    found = []
    for way, of_way in rows.groupby("method", sort=False):
        here = _at(of_way, claim["value"])
        there = None if pd.isna(claim["of"]) else _at(of_way, claim["of"])
        if here is None or (there is None and not pd.isna(claim["of"])):
            continue
        bad = (here["failed"] + here["lost"]) / here["seeds"]
        if claim["rule"] == "fails":
            enough = 1.0 if there is None else 1 - (there["failed"] + there["lost"]) / there["seeds"]
            found.append(Found(str(way), bad, seeds=int(here["seeds"]), succeeded=enough))
        elif there is not None:
            ratio = here["median"] / there["median"]
            found.append(Found(str(way), ratio, seeds=int(here["seeds"]), succeeded=1 - bad))
        else:
            found.append(_over_seeds(str(way), here))
    return found


def _at(rows: Any, value: Any) -> dict[str, Any] | None:
    """Return the row at a value on the axis of a sweep; None without one."""
    near = rows[np.isclose(rows["value"], float(value), rtol=1e-9, atol=0)]
    return near.iloc[0].to_dict() if len(near) else None


def _of_sequential(claim: Mapping[str, Any], summary: Any) -> list[Found]:
    """Return for each order the share of seeds in which one pass is worse than fitting at once: in the first case, and the least as ``low``."""
    rows = summary[
        (summary["stage"] == "one_pass")
        & (summary["alignment"] == "raw")
        & (summary["quantity"] == claim["quantity"])
    ]
    found = []
    for way, of_way in rows.groupby("way", sort=False):
        shares = of_way["worse_than_at_once"]
        found.append(
            Found(
                str(way), float(shares.iloc[0]), low=float(shares.min()), seeds=int(of_way["seeds"].iloc[0])
            )
        )
    return found
