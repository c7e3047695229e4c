"""Stand-ins for fitted states and scores, with which tests try single decisions of the diagnosis."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

from scalar.diagnosis.naming.finding import Finding
from scalar.diagnosis.scoring.ranking import Scored
from scalar.diagnosis.settings import DEFAULTS


def scored(effect: Any, evidence: float = 100.0, p_value: float = 1e-9, dof: int = 1) -> Scored:
    """Return an effect with a score."""
    return Scored(effect, 1.0, dof, evidence, p_value, 1.0)


class Tried(Exception):
    """Raised by the stand-in of a refit: an alternative was good enough to be fitted."""


def tried(*_: Any) -> Any:
    """Raise ``Tried`` in place of a refit."""
    raise Tried


def state(**more: Any) -> Any:
    """Return a stand-in for a fitted state: it has the default settings, and its refit raises ``Tried``."""
    return SimpleNamespace(settings=DEFAULTS, refitted=tried, **more)


def doubled(settings: Any, name: str) -> Any:
    """Return settings with one threshold doubled."""
    return replace(settings, **{name: 2 * getattr(settings, name)})


def finding_of(effect: Any, confidence: float) -> Finding:
    """Return a finding of which nothing is known but its effect and its confidence."""
    unknown: Any = None
    return Finding(effect, 1.0, unknown, unknown, (), confidence, (), unknown)


def sure_finding(effect: Any, log_odds: float = 10.0, **more: Any) -> Finding:
    """Return a finding with a confidence of 0.95 and these log odds [nats]; ``more`` are further attributes."""
    grounds: Any = SimpleNamespace(log_odds=log_odds)
    return replace(finding_of(effect, 0.95), grounds=grounds, **more)
