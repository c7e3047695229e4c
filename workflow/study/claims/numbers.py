"""The verdicts on the claims as numbers for the paper: for each claim and way to calibrate, and the number of claims with each verdict."""

from __future__ import annotations

from typing import Any

import pandas as pd

from study.claims.judge import ABSENT, CONFIRMED, DIFFERS, FAILS
from study.common.methods import PROPOSED


def claim_numbers(table: pd.DataFrame) -> dict[str, Any]:
    """Return ``{"counts": {verdict: number of claims}, "claims": {claim: {statement, where, published, verdict, ways}}}``.

    The verdict of a claim is that on the proposed method; if that is none of its ways, it is the least favourable one. Units are in the names:
    ``published_mm``.

    Args:
        table: As ``judge_claims`` returns it.
    """
    rank = [CONFIRMED, DIFFERS, FAILS]
    claims: dict[str, Any] = {}
    for name, rows in table.groupby("claim", sort=False):
        first: Any = rows.iloc[0]
        unit = f"_{first['unit']}" if first["unit"] else ""
        ways = {
            (row["way"] or "any"): {
                f"found{unit}": _plain(row["found"]),
                f"low{unit}": _plain(row["low"]),
                f"high{unit}": _plain(row["high"]),
                "seeds": int(row["seeds"]),
                "verdict": row["verdict"],
                "why": row["why"],
            }
            for row in rows.to_dict("records")
        }
        judged = [w["verdict"] for w in ways.values() if w["verdict"] in rank]
        worst = max(judged, key=rank.index) if judged else ABSENT
        claims[str(name)] = {
            "statement": first["statement"],
            "where": first["where"],
            f"published{unit}": float(first["published"]),
            "verdict": ways[PROPOSED]["verdict"] if PROPOSED in ways else worst,
            "ways": ways,
        }
    verdicts = [claim["verdict"] for claim in claims.values()]
    counts = {v.replace(" ", "_"): verdicts.count(v) for v in (CONFIRMED, DIFFERS, FAILS, ABSENT)}
    return {"counts": counts | {"all": len(claims)}, "claims": claims}


def _plain(value: Any) -> float | None:
    return None if pd.isna(value) else float(value)
