"""Numbers with a sign between groups of three digits, as ``1.010,5`` or ``1,010.5``: what to write in their place."""

import re

_GROUPED = re.compile(
    r"(?P<minus>[-+]?)(?P<whole>[1-9][0-9]{0,2}(?P<sign>[.,' ])[0-9]{3}(?:(?P=sign)[0-9]{3})*)(?:(?P<decimal>[.,])(?P<part>[0-9]+))?"
)
_NAMES = {".": "points", ",": "commas", "'": "apostrophes", " ": "blanks"}


def remedy_of_groups(cell: str) -> str | None:
    """Return what is to be written in the place of a cell that has a sign between thousands; None if it has none, or may have a decimal sign there.

    A point or a comma before three digits (``1,010``) is said to stand between thousands only if it stands there twice, or the other of the two
    begins the decimals.
    """
    found = _GROUPED.fullmatch(cell)
    if found is None or found["decimal"] == found["sign"]:
        return None
    if found["sign"] in ".," and found["part"] is None and found["whole"].count(found["sign"]) == 1:
        return None
    digits = found["minus"] + found["whole"].replace(found["sign"], "")
    meant = digits if found["part"] is None else f"{digits}.{found['part']}"
    other = (
        ""
        if found["part"] is None
        else f" (or {digits},{found['part']} where all of a table with semicolons has decimal commas)"
    )
    return f"leave out the {_NAMES[found['sign']]} between thousands: write {meant}{other}"
