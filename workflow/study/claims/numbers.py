"""The verdicts on the claims as numbers for the paper: of each claim by way to calibrate, and how many there are of each verdict."""

from __future__ import annotations

from typing import Any

import pandas as pd

from study.claims.judge import ABSENT, CONFIRMED, DIFFERS, FAILS
from study.common.methods import PROPOSED


def claim_numbers(table: pd.DataFrame) -> dict[str, Any]:
    """Return ``{"claims": {claim: {published, ways}}, "counts": {verdict: n}}``.

    Counts are of the verdicts on the proposed method, or on the only one. Units stand in the names: ``published_mm``. The
    verdict of a claim is that on the proposed method; where ways are orders of steps, it is the least favourable.
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
