"""Make characters visible that the eye does not see, so that a name reads as what it is.

Characters that turn the direction of text round, join or hide letters (Unicode Technical Report 36) may stand in a name of the
user's file, and would make the page say something else than the file. Each is written as its escape, ``\\u202e``.
"""

import re

_UNSEEN = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\xad\u061c\u180e\u200b-\u200f\u2028-\u202e\u2060-\u206f\ufeff\ufff9-\ufffb\ud800-\udfff"
    "\U000e0000-\U000e007f]"
)
"""Control characters but tabulator and line feed, marks and overrides of direction, characters of no width, halves of characters."""


def visible(page: str) -> str:
    """Return a page with an escape in place of each character that is not seen but acts."""
    return _UNSEEN.sub(lambda found: found[0].encode("unicode_escape").decode("ascii"), page)
