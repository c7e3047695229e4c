"""Make invisible characters visible, so that no name looks like another.

Characters that reverse the direction of text, join or hide letters (Unicode Technical Report 36) may be part of a name in the
user's file, and would make the page show something else than the file has. Each is written as its escape, such as ``\\u202e``.
"""

import re

_UNSEEN = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\xad\u061c\u180e\u200b-\u200f\u2028-\u202e\u2060-\u206f\ufeff\ufff9-\ufffb\ud800-\udfff"
    "\U000e0000-\U000e007f]"
)
"""Control characters except tabulator and line feed, marks and overrides of direction, characters of no width, and surrogates."""


def visible(page: str) -> str:
    """Return a page with an escape in place of each invisible character."""
    return _UNSEEN.sub(lambda found: found[0].encode("unicode_escape").decode("ascii"), page)
