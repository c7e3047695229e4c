"""Let the estimator run on traced thresholds (``study.sensitivity.traced``): replace its loops' ``range`` and a few of its functions.

A function that sets outliers aside compares every point with a threshold. An alternative threshold diverges as soon as one point lies between the
two thresholds, although the function often returns the same result for both. A function that depends on its arguments alone is therefore called
again with every alternative that diverged inside it, and only alternatives with another result are recorded as diverged. This takes milliseconds
and often saves a whole diagnosis.
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
    """Return whether two results have the same content, to the last bit.

    Compared are numbers, texts, arrays, tables, dataclasses and collections of these; values of other types must be the same object.
    """
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
    """Return whether two confidences are both ``SURE`` or above, or both below; the compared answers contain nothing else of a confidence."""
    return (a >= SURE) == (b >= SURE)


COMPARED_BY_RESULT: dict[str, Callable[[Any, Any], bool]] = {
    "scalar.estimation.outlying_points.without_outlying_points": same_content,
    "scalar.estimation.pose_consistency.coarsely_consistent": same_content,
    "scalar.estimation.data_sheet_priors.fit_near_data_sheet": same_content,
    "scalar.diagnosis.held_out.repetitions.first_of_repetitions": same_content,
    "scalar.diagnosis.naming.confidence.confidence": same_side,
}
"""By dotted name, functions that depend on nothing but their arguments, each with the test whether two of its results are the same."""


def comparing_results(function: Callable[..., Any], same: Callable[[Any, Any], bool]) -> Callable[..., Any]:
    """Return the function with alternatives recorded as diverged only if they lead to another result.

    Args:
        function: Depends on its arguments alone, some of which may be traced numbers or settings with such numbers.
        same: Says whether two of its results are the same.
    """

    @wraps(function)
    def call(*positional: Any, **named: Any) -> Any:
        arguments = (*positional, *named.values())
        trace = next((trace for trace in map(_trace_of, arguments) if trace is not None), None)
        if trace is None:
            return function(*positional, **named)

        def result_under(alternative: Any, inner: Trace | None = None) -> Any:
            values = [_under(x, alternative, inner) for x in arguments]
            return function(
                *values[: len(positional)], **dict(zip(named, values[len(positional) :], strict=True))
            )

        inside = Trace()
        traced_result = result_under(None, inside)
        plain_result = result_under(None)
        trace.used |= inside.used
        # If the result contains traced numbers, an alternative may change it without having diverged inside: all that were used are tried.
        to_try = inside.diverged if same_content(plain_result, traced_result) else inside.used
        for alternative in to_try - trace.diverged:
            try:
                is_same = same(result_under(alternative), plain_result)
            except Exception:  # the alternative fails where the value does not
                is_same = False
            if not is_same:
                trace.diverged.add(alternative)
        return plain_result

    return call


def _trace_of(argument: Any) -> Trace | None:
    """Return the trace of a traced number, or of the first traced number in settings; None without one."""
    if isinstance(argument, Traced):
        return argument.trace
    if _is_settings(argument):
        found = (_trace_of(getattr(argument, item.name)) for item in fields(argument))
        return next((trace for trace in found if trace is not None), None)
    return None


def _under(argument: Any, alternative: Any, inner: Trace | None) -> Any:
    """Return an argument with its traced numbers replaced: by those recorded in the trace ``inner``, or without it by plain numbers.

    The plain numbers are those of the alternative, or the values themselves if the alternative is None.
    """
    if isinstance(argument, Traced):
        if inner is not None:
            return Traced(argument.value, argument.alternatives, inner)
        return argument.alternatives.get(alternative, argument.value)
    if _is_settings(argument):
        parts = {item.name: getattr(argument, item.name) for item in fields(argument)}
        return replace(argument, **{name: _under(part, alternative, inner) for name, part in parts.items()})
    return argument


def _is_settings(argument: Any) -> bool:
    return (
        is_dataclass(argument)
        and not isinstance(argument, type)
        and type(argument).__name__.endswith("Settings")
    )


@contextmanager
def traced_estimator(package: str = "scalar") -> Iterator[None]:
    """Within the block, let the modules of a package use ``counted`` as ``range``, and wrap the functions of ``COMPARED_BY_RESULT``."""
    modules = [
        module
        for name, module in list(sys.modules.items())
        if name.split(".")[0] == package and module is not None
    ]
    wrapped = {
        _function_named(name): comparing_results(_function_named(name), same)
        for name, same in COMPARED_BY_RESULT.items()
    }
    originals = [
        (module, name, value)
        for module in modules
        for name, value in vars(module).items()
        if _is_in(value, wrapped)
    ]
    with_builtin_range = [module for module in modules if "range" not in vars(module)]
    try:
        for module, name, value in originals:
            vars(module)[name] = wrapped[value]
        for module in with_builtin_range:
            vars(module)["range"] = counted
        yield
    finally:
        for module, name, value in originals:
            vars(module)[name] = value
        for module in with_builtin_range:
            vars(module).pop("range", None)


def _function_named(dotted: str) -> Callable[..., Any]:
    module, name = dotted.rsplit(".", 1)
    return vars(sys.modules[module])[name]


def _is_in(value: Any, functions: dict[Callable[..., Any], Any]) -> bool:
    return (
        callable(value)
        and not isinstance(value, type | ModuleType)
        and any(value is key for key in functions)
    )
