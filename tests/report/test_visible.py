"""Characters that are not seen but act are written as escapes; all others stay as they are."""

import unicodedata

import pytest

from scalar.report.visible import visible


@pytest.mark.parametrize(
    "character", "\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069\u200e\u200f\u061c"
)
def test_a_mark_of_direction_becomes_its_escape(character: str) -> None:
    """Each of the twelve controls of the bidirectional algorithm is written as its number."""
    assert visible(f"a{character}b") == f"a\\u{ord(character):04x}b"


def test_what_is_seen_stays() -> None:
    """Letters of any script, spaces, signs and line ends are no controls, and stay."""
    kept = "".join(chr(i) for i in range(0x3000) if unicodedata.category(chr(i))[0] in "LMNPSZ")
    kept = kept.replace("\u2028", "").replace("\u2029", "")
    assert visible(kept + "\n\t") == kept + "\n\t"
