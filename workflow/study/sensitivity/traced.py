"""Numbers that carry alternative values, and record which alternatives would have changed the computation.

One diagnosis with traced thresholds replaces many. Each traced number contains its value and, by name, its alternatives, for example one threshold
halved or another one doubled. Arithmetic is done on the value and on every alternative. When a result decides how the computation continues or
leaves Python's arithmetic (a comparison, the end of a loop, an array, a conversion to a plain number), it is computed with the value and with every
alternative: an alternative with another result is recorded in ``Trace.diverged`` and not followed any further. By induction, an alternative that is
not in ``diverged`` at the end would have taken every step that the diagnosis took, with the same numbers: its answer is known without a run. One
that is in ``diverged`` has to be run; its answer may still be the same.

``Traced`` is not a ``float``, since C code reads the bits of a float directly, which could not be recorded. If it cannot be used in place of a
number, the computation fails, and all variants of the set are then run. A loop ``for _ in range(threshold)`` would convert its bound to a plain
number at once; ``counted`` compares the count with the bound in each round, so that a loop that is left before any of the bounds counts as the same.
"""

from __future__ import annotations

import builtins
import math
import operator
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from numbers import Number
from typing import Any

import numpy as np


@dataclass(eq=False)
class Trace:
    """What a computation did with its traced numbers.

    Attributes:
        used: Names of alternatives whose numbers entered any operation.
        diverged: Names of alternatives under which the result of an operation differed from that of the value.
    """

    used: set[Any] = field(default_factory=set)
    diverged: set[Any] = field(default_factory=set)


class Traced:
    """A number and, by name, the values that it would have under each alternative."""

    __slots__ = ("alternatives", "trace", "value")

    def __init__(self, value: Any, alternatives: Mapping[Any, Any], trace: Trace) -> None:
        """Take a plain number, its alternatives by name, and the trace in which they are recorded."""
        self.value, self.alternatives, self.trace = value, dict(alternatives), trace

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **options: Any) -> Any:
        """Return the result of a NumPy ufunc; if it writes into a given array, all alternatives diverge."""
        call = getattr(ufunc, method)
        if "out" in options:
            _traces(inputs).diverged.update(_names(inputs))
            return call(*(_under(x, None) for x in inputs), **options)
        return _applied(lambda *given: call(*given, **options), inputs)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Any:
        """Return it as an array, in which no alternative is followed."""
        return np.array(_plain_result(lambda value: value, self), dtype=dtype)

    def __float__(self) -> float:
        """Return the plain number."""
        return _plain_result(float, self)

    def __int__(self) -> int:
        """Return the plain whole number."""
        return _plain_result(int, self)

    def __index__(self) -> int:
        """Return the plain whole number, for an index or a count."""
        return _plain_result(operator.index, self)

    def __bool__(self) -> bool:
        """Return whether it is not zero."""
        return _plain_result(bool, self)

    def __hash__(self) -> int:
        """Return the number's hash."""
        return _plain_result(hash, self)

    def __str__(self) -> str:
        """Return the number's text."""
        return _plain_result(str, self)

    __repr__ = __str__

    def __getitem__(self, key: Any) -> Any:
        """Return an element or a slice of an array, under every alternative."""
        return _applied(operator.getitem, (self, key))

    def __len__(self) -> int:
        """Return the length of an array."""
        return _plain_result(len, self)

    def __iter__(self) -> Iterator[Any]:
        """Yield what an array holds."""
        return (self[i] for i in range(len(self)))

    def __getattr__(self, name: str) -> Any:
        """Return what the plain value has by a name; no alternative is followed further."""
        if name.startswith("__"):  # protocols that the value may have and this class has not
            raise AttributeError(name)
        self.trace.used.update(self.alternatives)
        self.trace.diverged.update(self.alternatives)
        return getattr(self.value, name)

    def __format__(self, form: str) -> str:
        """Return the number's text in a format."""
        return _plain_result(lambda value: format(value, form), self)


def _operation(function: Callable[..., Any], reflected: bool = False) -> Callable[..., Any]:
    """Return a method that does an operator's work on the value and on every alternative."""

    def method(self: Traced, *others: Any) -> Any:
        return _applied(function, (*others, self) if reflected else (self, *others))

    return method


for _name in ("lt", "le", "gt", "ge", "eq", "ne", "neg", "pos", "abs"):
    setattr(Traced, f"__{_name}__", _operation(getattr(operator, _name)))
for _name in ("add", "sub", "mul", "matmul", "truediv", "floordiv", "mod", "pow"):
    setattr(Traced, f"__{_name}__", _operation(getattr(operator, _name)))
    setattr(Traced, f"__r{_name}__", _operation(getattr(operator, _name), reflected=True))
for _name, _function in (("round", round), ("ceil", math.ceil), ("floor", math.floor), ("trunc", math.trunc)):
    setattr(Traced, f"__{_name}__", _operation(_function))
Number.register(Traced)  # NumPy and SciPy take it for a scalar where they ask


def _applied(function: Callable[..., Any], inputs: tuple[Any, ...]) -> Any:
    """Return a function's result, traced if it is a number that differs under an alternative."""
    trace = _traces(inputs)
    names = _names(inputs)
    trace.used |= names
    value = function(*(_under(x, None) for x in inputs))
    followed = {}
    for name in names - trace.diverged:
        try:
            other = function(*(_under(x, name) for x in inputs))
        except Exception:  # the alternative fails where the value does not
            trace.diverged.add(name)
            continue
        if _same(other, value):
            continue
        if _is_numeric(value) and _is_numeric(other):
            followed[name] = other
        else:
            trace.diverged.add(name)
    return Traced(value, followed, trace) if followed else value


def _plain_result(function: Callable[[Any], Any], number: Traced) -> Any:
    """Return a function's result for the value; alternatives with another result diverge."""
    trace = number.trace
    trace.used.update(number.alternatives)
    value = function(number.value)
    for name in set(number.alternatives) - trace.diverged:
        try:
            same = _same(function(number.alternatives[name]), value)
        except Exception:  # the alternative fails where the value does not
            same = False
        if not same:
            trace.diverged.add(name)
    return value


def _under(given: Any, name: Any) -> Any:
    """Return a number under the alternative of a name (None: its value); anything else as it is."""
    return given.alternatives.get(name, given.value) if isinstance(given, Traced) else given


def _names(inputs: tuple[Any, ...]) -> set[Any]:
    """Return the names of all alternatives of traced numbers."""
    return {name for x in inputs if isinstance(x, Traced) for name in x.alternatives}


def _traces(inputs: tuple[Any, ...]) -> Trace:
    """Return the trace of the first traced number; all of a computation have the same one."""
    return next(x.trace for x in inputs if isinstance(x, Traced))


def _is_numeric(value: Any) -> bool:
    """Return whether a result is a number or an array of numbers; truth values and everything else steer the computation, and are not followed."""
    if isinstance(value, np.ndarray):
        return value.dtype.kind in "iuf"
    return isinstance(value, Number | np.number) and not isinstance(value, bool | np.bool_)


def _same(a: Any, b: Any) -> bool:
    """Return whether two results are the same to the last bit, arrays included; NaN is NaN."""
    a, b = np.asarray(a), np.asarray(b)
    if a.shape != b.shape:
        return False
    return bool(np.all((a == b) | ((a != a) & (b != b))))


def counted(*bounds: Any) -> Any:
    """Return ``range(*bounds)``; with a traced bound, count up and compare with it each time."""
    if not any(isinstance(bound, Traced) for bound in bounds):
        return builtins.range(*bounds)
    begin, end, step = (0, *bounds, 1) if len(bounds) == 1 else (*bounds, 1)[:3]
    return _counting(begin, end, step)


def _counting(begin: Any, end: Any, step: Any) -> Iterator[int]:
    i = operator.index(begin)
    step = operator.index(step)
    while i < end if step > 0 else i > end:
        yield i
        i += step
