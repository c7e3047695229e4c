"""Numbers as foreign tables write them: with a decimal comma, with signs between thousands; and the row of units that may stand below the names."""

import re
from collections.abc import Iterable
from dataclasses import dataclass

from scalar.data.located_table import NUMBER

_UNIT = re.compile(r"[\[(]?[^\W\d_]{0,4}[°º'\"/%²³·^.*\-]{0,2}[^\W\d_]{0,4}[\])]?")
"""A cell of a row of units: a few letters and signs, perhaps in brackets, and no digit."""
_UNIT_BEHIND = re.compile(r"(.*[0-9.,])\s*(°|º|deg|rad|mm|cm|m|in)")
"""A cell with a number and its unit."""
_PLAIN = str.maketrans({"\N{NO-BREAK SPACE}": " ", "\N{NARROW NO-BREAK SPACE}": " ", "\N{MINUS SIGN}": "-"})
"""Signs that programs for text write in place of a blank and of a hyphen."""
_NAMES = {",": "comma", ".": "point"}
MAPPED = "under text in the mapping"
"""What a hint says that a change of the mapping mends, for all cells that are written alike."""


@dataclass(frozen=True)
class Written:
    """How a table writes its numbers.

    Attributes:
        decimal: The decimal sign, ``.`` or ``,``.
        thousands: The sign between groups of three digits, ``.``, ``,``, ``'`` or a blank; empty if there is none.
    """

    decimal: str = "."
    thousands: str = ""

    def number(self, cell: str) -> float | None:
        """Return the number in a cell, or None if it is none as this table writes them."""
        plain = cell.translate(_PLAIN)
        if self.thousands and re.fullmatch(_grouped(self.thousands, self.decimal), plain):
            plain = plain.replace(self.thousands, "")
        if self.decimal == ",":
            if "." in plain:
                return None
            plain = plain.replace(",", ".")
        return float(plain) if NUMBER.fullmatch(plain) else None

    def hint(self, cell: str, table: Iterable[str] = ()) -> str:
        """Return what the user should do about a cell that is no number.

        Args:
            cell: The cell.
            table: Cells of the same table. A sign before three digits may be the decimal sign or separate thousands; others may show which.
        """
        if (behind := _UNIT_BEHIND.fullmatch(cell)) is not None and self.number(behind[1]) is not None:
            return f"remove {behind[2]!r} from the cells: the mapping states the unit of the column"
        other = "," if self.decimal == "." else "."
        as_decimal = Written(other).number(cell) is not None
        for sign in (other, "'", " "):
            if sign != self.thousands and Written(self.decimal, sign).number(cell) is not None:
                return self._hint_at_either(sign, table) if sign == other and as_decimal else _separates(sign)
        if self.decimal == "." and as_decimal:
            instead = f' in place of thousands: "{other}"' if self.thousands == other else ""
            return f"if this is a decimal comma, write decimal: ','{instead} under text in the mapping"
        if self.decimal in cell and Written(other, self.decimal).number(cell) is not None:
            return f"if '{self.decimal}' separates thousands, write decimal: '{other}' and thousands: '{self.decimal}' under text in the mapping"
        return f"the mapping says decimal: '{self.decimal}'" if other in cell else "correct it"

    def _hint_at_either(self, sign: str, table: Iterable[str]) -> str:
        """Return what to do about a sign before three digits, which other cells of the table may show to be of one kind."""
        grouped, as_decimal = Written(self.decimal, sign), Written(sign)
        for cell in table:
            in_groups, decimal = grouped.number(cell), as_decimal.number(cell)
            if sign in cell and in_groups is None and decimal is not None:
                return f"write decimal: '{sign}' under text in the mapping, since {cell!r} in this table has a decimal {_NAMES[sign]}"
            if sign in cell and in_groups is not None and decimal is None:
                return f"write thousands: \"{sign}\" under text in the mapping, since '{sign}' separates thousands in {cell!r} of this table"
        return f"if '{sign}' is the decimal sign, write decimal: '{sign}' under text in the mapping; {_separates(sign, '')}"


def _separates(sign: str, where: str = " under text in the mapping") -> str:
    """Return what to write where a sign may separate thousands."""
    return f"if '{sign}' separates thousands, write thousands: \"{sign}\"{where}"


def _grouped(thousands: str, decimal: str) -> str:
    """Return the pattern of a number with signs between all groups of three digits, of which there are two at least; none begins with 0."""
    return rf"[-+]?[1-9]\d{{0,2}}({re.escape(thousands)}\d{{3}})+({re.escape(decimal)}\d*)?"


def is_row_of_units(cells: list[str], below: list[str], written: Written, missing: frozenset[str]) -> bool:
    """Return whether a row states the units of the columns: short words without a digit where the row below it has numbers.

    Args:
        cells: The first row below the names of the columns.
        below: The row after it.
        written: How the table writes numbers.
        missing: Texts, in lower case, which mean that nothing was measured; they are no units.
    """
    if not any(cells) or any(cell and cell.lower() in missing for cell in cells):
        return False
    if not all(_UNIT.fullmatch(cell) for cell in cells):
        return False
    numbers = [written.number(cell) is not None for cell in below]
    named = [bool(cell) and is_number for cell, is_number in zip(cells, numbers, strict=False)]
    return 2 * sum(named) > sum(map(bool, cells))
