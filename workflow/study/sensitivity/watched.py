"""The estimator under a trace: its loops count by comparisons, and some of its functions are judged by what they return.

A function that sets wrong points aside compares every point with a threshold. An alternative threshold parts as soon as one point lies between
the two, though the function often returns the same. A function that depends on its arguments alone is therefore called again under
every alternative that parted inside it, and only alternatives with another result part for good. This takes milliseconds and often saves a whole
diagnosis.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import fields, is_dataclass, replace
from functools import wraps
from types import ModuleType
from typing import Any

import numpy as np
import pandas as pd

from study.blind_trials.score import SURE
from study.sensitivity.traced import Trace, Traced, counted


def same_content(a: Any, b: Any) -> bool:
    """Return whether two results hold the same, to the last bit; values of other types are the same only if they are the same object."""
    if a is b:
        return True
    if isinstance(a, np.ndarray | float | int | str | None) and isinstance(
        b, np.ndarray | float | int | str | None
    ):
        return np.array_equal(a, b) if isinstance(a, np.ndarray) else bool(np.all(a == b))  # type: ignore[arg-type]
    if type(a) is not type(b):
        return False
    if isinstance(a, pd.DataFrame):
        return a.equals(b)
    if isinstance(a, dict):
        return a.keys() == b.keys() and all(same_content(a[key], b[key]) for key in a)
    if isinstance(a, tuple | list):
        return len(a) == len(b) and all(map(same_content, a, b))
    if is_dataclass(a):
        return all(same_content(getattr(a, item.name), getattr(b, item.name)) for item in fields(a))
    return False


def same_side(a: float, b: float) -> bool:
    """Return whether two confidences are both ``SURE`` or above, or both below: the compared answers hold no more of them."""
    return (a >= SURE) == (b >= SURE)


JUDGED: dict[str, Callable[[Any, Any], bool]] = {
    "scalar.estimation.outlying_points.without_outlying_points": same_content,
    "scalar.estimation.pose_consistency.coarsely_consistent": same_content,
    "scalar.estimation.data_sheet_priors.fit_near_data_sheet": same_content,
    "scalar.diagnosis.hold_out.first_of_repetitions": same_content,
    "scalar.diagnosis.confidence.confidence": same_side,
}
"""Functions that depend on nothing but their arguments, and when two of their results are the same."""


def judged(function: Callable[..., Any], same: Callable[[Any, Any], bool]) -> Callable[..., Any]:
    """Return a function under which alternatives part only if they lead to another result."""

    @wraps(function)
    def call(*given: Any, **options: Any) -> Any:
        everything = (*given, *options.values())
        trace = next((trace for trace in map(_trace_of, everything) if trace is not None), None)
        if trace is None:
            return function(*given, **options)

        def under(name: Any, inner: Trace | None = None) -> Any:
            taken = [_under(x, name, inner) for x in everything]
            return function(*taken[: len(given)], **dict(zip(options, taken[len(given) :], strict=True)))

        inside = Trace()
        followed = under(None, inside)
        plain = under(None)
        trace.used |= inside.used
        # A result that is traced itself may go on; each alternative that entered it is then asked for its own.
        asked = inside.parted if same_content(plain, followed) else inside.used
        for name in asked - trace.parted:
            try:
                is_same = same(under(name), plain)
            except Exception:  # the alternative fails where the value does not
                is_same = False
            if not is_same:
                trace.parted.add(name)
        return plain

    return call


def _trace_of(given: Any) -> Trace | None:
    """Return the trace of a traced number, or of the first in settings; None without one."""
    if isinstance(given, Traced):
        return given.trace
    if _is_settings(given):
        found = (_trace_of(getattr(given, item.name)) for item in fields(given))
        return next((trace for trace in found if trace is not None), None)
    return None


def _under(given: Any, name: Any, inner: Trace | None) -> Any:
    """Return an argument with plain numbers under an alternative; with a trace, with numbers that note there what becomes of them."""
    if isinstance(given, Traced):
        if inner is not None:
            return Traced(given.value, given.alternatives, inner)
        return given.alternatives.get(name, given.value)
    if _is_settings(given):
        return replace(
            given, **{item.name: _under(getattr(given, item.name), name, inner) for item in fields(given)}
        )
    return given


def _is_settings(given: Any) -> bool:
    return is_dataclass(given) and not isinstance(given, type) and type(given).__name__.endswith("Settings")


@contextmanager
def watched_estimator(package: str = "scalar") -> Iterator[None]:
    """Let the modules of the estimator count by ``counted`` and call the functions of ``JUDGED`` as ``judged``, within the block."""
    modules = [
        module
        for name, module in list(sys.modules.items())
        if name.split(".")[0] == package and module is not None
    ]
    instead = {_found(name): judged(_found(name), same) for name, same in JUDGED.items()}
    before = [
        (module, name, value)
        for module in modules
        for name, value in vars(module).items()
        if _is_in(value, instead)
    ]
    counting = [module for module in modules if "range" not in vars(module)]
    try:
        for module, name, value in before:
            vars(module)[name] = instead[value]
        for module in counting:
            vars(module)["range"] = counted
        yield
    finally:
        for module, name, value in before:
            vars(module)[name] = value
        for module in counting:
            vars(module).pop("range", None)


def _found(dotted: str) -> Callable[..., Any]:
    module, name = dotted.rsplit(".", 1)
    return vars(sys.modules[module])[name]


def _is_in(value: Any, functions: dict[Callable[..., Any], Any]) -> bool:
    return (
        callable(value)
        and not isinstance(value, type | ModuleType)
        and any(value is key for key in functions)
    )
