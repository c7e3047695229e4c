"""How the diagnosis of a simulated set ended, and what it says, as entries of the set's row."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from traceback import print_exc
from typing import Any

from scalar.errors import ScalarError

CRASHED = "crashed"
"""Status of a set whose diagnosis ended in an error that is a defect of this program."""


def outcome(answer: Callable[[], Mapping[str, Any]]) -> dict[str, Any]:
    """Return the entries of an answer with their status; without an answer, the error that ended it as status, and the reason.

    Args:
        answer: Diagnoses the set and returns the entries.
    """
    try:
        return {"status": "diagnosed", **answer()}
    except ScalarError as error:
        return {"status": type(error).__name__, "reason": str(error).splitlines()[0]}
    except Exception as error:  # a defect of this program: counted, and the other sets are still run
        print_exc()
        return {"status": CRASHED, "reason": f"{type(error).__name__}: {error}".splitlines()[0]}


def stated(mapping: Mapping[str, Any]) -> dict[str, Any]:
    """Return the verdict of a ``diagnosis.json`` and, as JSON, the effects without their coefficients, and those that are unobservable."""
    found = [{k: v for k, v in entry.items() if k != "coefficients"} for entry in mapping["effects"]]
    unobservable = [{"name": s["name"], "target": s["target"]} for s in mapping["unobservable"]]
    return {
        "verdict": mapping["verdict"],
        "found": json.dumps(found),
        "unobservable": json.dumps(unobservable),
    }
