"""Judge every claim of the original paper on the results of a run, by stated rules; no verdict is written by hand.

A claim is a row of ``judged_claims.csv``: its number, the section that makes it, the table that answers it and the rule by which it is judged. The
values found (``answers``) are judged for each *way* to calibrate: a method, or an order of steps. The rules:

- ``reached``: an accuracy. It is confirmed if it lies in the band; it *differs* if the whole band is better; else it does not hold.
- ``draw``, ``value``: a number of one run. It is confirmed if it lies within the range of the seeds. Else it differs, but a ``value`` does not hold
  if the median is more than ``FAR`` times larger or smaller.
- ``enough``: more data change nothing. It is confirmed if the error is at most ``SAME`` times that with more data, does not hold from ``CHANGED``
  times on, and differs in between.
- ``unaffected``: a change does no harm. It is judged like ``enough`` by the factor by which the error becomes larger or smaller; it does not hold if
  less than the share ``MOST`` of the fits succeeds, and at best differs if any fit fails.
- ``within``, ``fails``, ``at_once``: a share of the seeds. It is confirmed from ``MOST`` on, does not hold below one half, and differs in between;
  ``at_once`` also differs if a case other than the first has a share below ``MOST``.
- ``suffices``: the share of the seeds in which the fit succeeds with the data that the claim calls enough. It is judged like ``within``.
- ``everywhere``: the same of the places of the workspace instead of the seeds.
- ``most``: a share of the arms. It is confirmed above one half, else it does not hold.
- ``count``: it is confirmed if the numbers are equal, else it does not hold.
- ``duration``: it is confirmed if a fit takes less time, else it does not hold; without a measured time it is ``ABSENT``.

A fit that failed confirms nothing: if less than the share ``MOST`` of the fits succeeds, ``reached``, ``value`` and ``enough`` differ at best; a seed
without a calibration has no plane within its limits; and ``fails`` is confirmed only if fits succeed with enough data.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd

from study.claims.answers import Found, Results, answers_of

CONFIRMED, DIFFERS, FAILS = "confirmed", "differs", "does not hold"
ABSENT = "not in this run"
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
    if rule == "most":
        verdict = CONFIRMED if found.value > 0.5 else FAILS
        return verdict, f"{_percent(found.value)} of the six-axis arms of our library"
    if rule == "duration" and not 0 < found.value < np.inf:
        return ABSENT, "no time was measured"
    if (
        rule == "duration"
    ):  # no time is stated, so that the table is the same on every machine that is fast enough
        return (
            (CONFIRMED, "timed, but not printed, so that two runs give the same table: a fit takes less")
            if found.value < published
            else (FAILS, "timed, but not printed, so that two runs give the same table: a fit takes longer")
        )
    if rule in ("within", "fails", "at_once", "suffices", "everywhere"):
        of = {"suffices": "fits succeed", "everywhere": "places"}.get(rule, "seeds")
        return _by_share(found.value), f"{_percent(found.value)} of the {of}"
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
