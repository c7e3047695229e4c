"""The outcome of killing a command, or the workflow, some times."""

from __future__ import annotations

import signal
import sys
from collections import Counter
from dataclasses import dataclass, field

HOWS = (signal.SIGTERM, signal.SIGKILL)


@dataclass
class Outcome:
    """Counts and faults of one command, or of the workflow.

    Attributes:
        kills: Number of kills that met a living process.
        hows: Number of kills by signal and by what it was sent to.
        partial: Number of kills after which some files of the new run were there, and others were not.
        left: Number of kills after which files of two runs lay in the folder.
        refused: Number of those that a reader refused.
        faults: A sentence for each thing that should not have happened.
    """

    kills: int = 0
    hows: Counter[str] = field(default_factory=Counter)
    partial: int = 0
    left: int = 0
    refused: int = 0
    faults: list[str] = field(default_factory=list)

    def killed(self, name: str, how: signal.Signals, whole_group: bool) -> str:
        """Count a kill that met a living process, and return a sentence's beginning that says which."""
        self.kills += 1
        self.hows[how.name] += 1
        self.hows["group" if whole_group else "alone"] += 1
        case = f"{name}, {how.name} to {'its group' if whole_group else 'it alone'}"
        print(f"kill {self.kills}: {case}; faults until now: {len(self.faults)}", file=sys.stderr, flush=True)
        return case

    def row(self, name: str) -> dict[str, str | int]:
        """Return a row of the table of kills."""
        hows = {what: self.hows[what] for what in (*(how.name for how in HOWS), "alone", "group")}
        seen = {
            "partial": self.partial,
            "two_runs": self.left,
            "refused": self.refused,
            "faults": len(self.faults),
        }
        return {"what": name, "kills": self.kills, **hows, **seen}
