"""The units are what their names say, and their numbers stand in one file."""

import ast
import math
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from scalar.units import DEG, MM, MRAD, MS, UM

ROOT = Path(__file__).parents[1]
CALLS = {"deg2rad", "rad2deg", "degrees", "radians"}
FACTORS = {1e3, 1e6, 1e-3, 1e-6}
UNIT_NAMES = {"mm", "µm", "um", "mrad", "deg", "°", "ms"}
CONSTANT = re.compile(
    r"_?(MM|UM|MS|MRAD|DEG|DEGREE|([A-Z]+_)?PER_[A-Z]+|[A-Z]+_TO_(MM|UM|MS|MRAD|DEG|RAD|M))"
)


def test_a_thousand_millimetres_are_a_metre() -> None:
    """1000 MM is one metre."""
    assert 1000 * MM == 1.0


def test_half_a_turn_is_pi() -> None:
    """180 degrees = pi rad, and dividing by the unit undoes multiplying by it."""
    assert 180 * DEG == math.pi
    assert math.isclose(37.5 * DEG / DEG, 37.5, rel_tol=1e-15)


def test_thousandths_are_thousandths() -> None:
    """1000 µm is 1 mm, 1000 mrad is 1 rad, and 1000 ms is 1 s."""
    assert math.isclose(1000 * UM, MM, rel_tol=1e-15)
    assert 1000 * MRAD == 1.0 == 1000 * MS


def number(node: ast.AST) -> float | None:
    """Return the number that a node writes, or None."""
    is_number = isinstance(node, ast.Constant) and type(node.value) in (int, float)
    return float(node.value) if is_number else None


def is_pi(node: ast.AST) -> bool:
    """Return whether a node is pi, of any library."""
    return (isinstance(node, ast.Attribute) and node.attr == "pi") or (
        isinstance(node, ast.Name) and node.id == "pi"
    )


def factors(node: ast.expr) -> Iterator[ast.expr]:
    """Yield the factors and divisors of a product, nested ones too."""
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Mult | ast.Div):
        yield from factors(node.left)
        yield from factors(node.right)
    else:
        yield node


def conversions(source: str) -> list[int]:
    """Return the lines of a source in which a unit is converted by a number or a function instead of a constant of units.py.

    These are: functions such as ``np.rad2deg``, 180 and pi in one product, a named constant of a unit, and a power of a thousand
    beside the name of a unit in a call, a tuple, a list or a mapping.
    """
    lines = []
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Call) and (
            (isinstance(node.func, ast.Attribute) and node.func.attr in CALLS)
            or (isinstance(node.func, ast.Name) and node.func.id in CALLS)
        ):
            lines.append(node.lineno)
        elif isinstance(node, ast.BinOp) and isinstance(node.op, ast.Mult | ast.Div):
            sides = list(factors(node))
            if any(is_pi(side) for side in sides) and any(number(side) == 180 for side in sides):
                lines.append(node.lineno)
        elif isinstance(node, ast.Assign) and number(node.value) in FACTORS:
            names = [target.id for target in node.targets if isinstance(target, ast.Name)]
            lines += [node.lineno for name in names if CONSTANT.fullmatch(name)]
        together: list[ast.AST] = []
        if isinstance(node, ast.Call):
            together = [*node.args, *(keyword.value for keyword in node.keywords)]
        elif isinstance(node, ast.Tuple | ast.List):
            together = list(node.elts)
        elif isinstance(node, ast.Dict):
            for key, value in zip(node.keys, node.values, strict=True):
                is_unit = isinstance(key, ast.Constant) and key.value in UNIT_NAMES
                lines += [node.lineno] if is_unit and number(value) in FACTORS else []
        named = any(isinstance(part, ast.Constant) and part.value in UNIT_NAMES for part in together)
        lines += [part.lineno for part in together if named and number(part) in FACTORS]  # type: ignore[attr-defined]
    return lines


@pytest.mark.parametrize(
    "source",
    [
        "np.rad2deg(x)",
        "x = degrees(y)",
        "x * 180 / np.pi",
        "x * (180 / np.pi)",
        "f = math.pi / 180.0",
        "MM = 1e-3",
        "_PER_MM = 1000.0",
        "scale = (length, 'mm', 1e3)",
        "Magnitude('scan', 'mm', 1000)",
        "{'mrad': 1e-3}",
    ],
)
def test_a_conversion_is_found_where_it_stands(source: str) -> None:
    """Each way in which this code base has converted units without units.py is found."""
    assert conversions(source)


@pytest.mark.parametrize(
    "source", ["x / MM", "tolerance = 1e-3", "('mm', 1 / MM)", "range(0, 180)", "LIMIT = 1e-3"]
)
def test_what_is_no_conversion_is_left_alone(source: str) -> None:
    """Constants of units.py, tolerances and angles in degrees are no conversions."""
    assert not conversions(source)


def test_units_are_converted_by_the_constants_of_one_file() -> None:
    """No file but units.py holds a number that converts millimetres, milliradians, milliseconds or degrees."""
    found = {
        f"{path.relative_to(ROOT)}:{line}"
        for folder in ("scalar", "workflow", "benchmarks", "paper")
        for path in (ROOT / folder).rglob("*.py")
        if path != ROOT / "scalar/units.py"
        for line in conversions(path.read_text(encoding="utf-8"))
    }
    assert found == set()
