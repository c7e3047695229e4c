"""Reading the paper's text: what is prose, what is mathematics, what is code; and the numbers typed in it.

A small reader of Typst, enough for this paper: ``#name(...)`` and ``#let``, ``#set``, ``#show``, ``#import``, ``#include`` and ``#if`` lines are
code, in which ``[...]`` is prose again and ``"..."`` a word; ``$...$`` is mathematics; ``//`` and ``/* */`` are comments.
"""

import re
from collections.abc import Iterator
from typing import NamedTuple

NAMES = {
    "2D",
    "3D",
    "VS060",
    "UR10",
    "UR10e",
    "MA1400",
    "MA1440",
    "MA2010",
    "PUMA",
    "560",
    "T-Mac",
    "SHA-256",
}
"""Words of prose that hold a digit and are no number: names of arms and kinds of sensors."""
NUMBER_WORDS = re.compile(
    r"\b(?!\w+ty-\w+(?:st|nd|rd|th)\b)(ten|eleven|twelve|\w+teen|twenty|thirty|forty|fifty|sixty|seventy|eighty|ninety|hundred|million"
    r"|(one|two|three|four|five|six|seven|eight|nine) (degrees?|millimet\w+|microm\w+|per cent|times|seconds?|minutes?|hours?))\b",
    re.IGNORECASE,
)
"""Numbers spelt out are typed as well, from ten on, and smaller ones before a unit; other small ones are words of the language, and ordinals are
names (the twenty-sixth exam, as the nineteenth)."""
ALLOWED_PHRASES = ("some hundreds", "tens of", "KUKA iiwa 7", "ABB IRB 120")
UNIT = re.compile(r"\d\s*(mm|µm|°|%|m\b|s\b|rad|mrad)")

CHECKED = re.compile(r"#says\(\s*\"[^\"]+\",\s*\"[^\"]+\"\s*\)")
"""A number written beside its key: ``#says("setup.seeds", "30")`` compiles only if the results have the same."""

KEY = re.compile(r"[A-Za-z][\w.-]*\.[\w.-]*")
"""A key of the numbers, whose names may hold a value and a unit."""


class Piece(NamedTuple):
    """A stretch of text of one kind: prose, math or code (a string in code)."""

    kind: str
    text: str
    line: int


def without_comments(text: str) -> str:
    """Return the text with comments blanked, lines kept; an address such as https://x is none."""
    text = re.sub(r"/\*.*?\*/", lambda m: re.sub(r"[^\n]", " ", m[0]), text, flags=re.DOTALL)
    return re.sub(r"(?<!:)//[^\n]*", "", text)


def pieces(text: str) -> Iterator[Piece]:
    """Yield the pieces of a Typst text."""
    yield from _Reader(without_comments(text)).prose(closing="")


class _Reader:
    def __init__(self, text: str) -> None:
        self.text, self.at = text, 0

    def _line(self) -> int:
        return self.text.count("\n", 0, self.at) + 1

    def prose(self, closing: str) -> Iterator[Piece]:
        """Yield pieces up to a closing bracket, or to the end of the text."""
        start, line, depth = self.at, self._line(), 0

        def words() -> Iterator[Piece]:
            if self.text[start : self.at].strip():
                yield Piece("prose", self.text[start : self.at], line)

        while self.at < len(self.text):
            c = self.text[self.at]
            if c == "\\":
                self.at += 2
                continue
            if c == "]" and closing == "]" and depth == 0:
                yield from words()
                self.at += 1
                return
            depth += (c == "[") - (c == "]")
            if c == "$":
                yield from words()
                yield self._math()
            elif c == "`":
                yield from words()
                self.at = self.text.index("`", self.at + 1) + 1
            elif c == "#":
                yield from words()
                yield from self._code()
            elif c in "@<" and (m := re.compile(r"@[\w-]+|<[\w-]+>").match(self.text, self.at)):
                yield from words()
                self.at = m.end()
            else:
                self.at += 1
                continue
            start, line = self.at, self._line()
        yield from words()

    def _math(self) -> Piece:
        line, end = self._line(), self.text.index("$", self.at + 1)
        piece = Piece("math", self.text[self.at + 1 : end], line)
        self.at = end + 1
        return piece

    def _code(self) -> Iterator[Piece]:
        """Yield the prose and the strings inside one piece of code, which ends where its brackets and its line do."""
        statement = re.compile(r"#(let|set|show|import|include|if|for|context)\b").match(self.text, self.at)
        self.at += 1
        start, depth = self.at, 0
        while self.at < len(self.text):
            c = self.text[self.at]
            if c in '"$' and depth == 0 and not statement and self.at > start:
                return
            if c == '"':
                end = self.at + 1
                while self.text[end] != '"':
                    end += 2 if self.text[end] == "\\" else 1
                yield Piece("code", self.text[self.at + 1 : end], self._line())
                self.at = end + 1
            elif c == "[":
                self.at += 1
                yield from self.prose(closing="]")
            elif c == "$":
                yield self._math()
            elif c in "({":
                depth += 1
                self.at += 1
            elif c in ")}":
                if depth == 0:
                    return
                depth -= 1
                self.at += 1
            elif depth == 0 and (c in "\n;" if statement else not re.match(r"[\w.-]", c)):
                return
            elif (
                depth == 0 and c == "." and not re.match(r"\.[a-z]", self.text[self.at : self.at + 2])
            ):  # a full stop ends it
                return
            else:
                self.at += 1


def typed_numbers(text: str) -> list[str]:
    """Return the numbers typed in a Typst text, each as ``line 7: ...``.

    In prose every digit is one, names of things (``NAMES``) excepted, and so is a number from ten on in words. In mathematics, decimals, and
    whole numbers of more than one digit. In code, words with a number and a unit (sizes of type and paper are no words). A number written beside
    its key (``CHECKED``) is checked by the compiler, and none of these.
    """
    found = []
    for kind, content, line in pieces(CHECKED.sub("", text)):
        if kind == "prose":
            for phrase in ALLOWED_PHRASES:
                content = content.replace(phrase, "")
            marks = [
                w
                for w in re.findall(r"[\w.,/×^+−-]*\d[\w.,/×^+−%°-]*", content)
                if w.strip(".,-") not in NAMES
            ]
            marks += [m[0] for m in NUMBER_WORDS.finditer(content)]
        elif kind == "math":
            marks = re.findall(r"\d+\.\d+|\d{2,}", content)
        else:
            marks = [content] if UNIT.search(content) and not KEY.fullmatch(content) else []
        found += [f"line {line}: {mark}" for mark in marks]
    return found


_READS = re.compile(r"\b(n|v|says|pct|name|short|symbol|listed)\(\s*\"([^\"]+)\"\s*[,)]")
_SHORT = re.compile(r"#let (\w+)\(key, digits: 2\) = (n|v)\(\"([^\"]+)\" \+ key, digits: digits\)")
_PICTURES = re.compile(r"#picture\(\s*\"([^\"]+)\"")


def quoted_keys(text: str) -> dict[str, str]:
    """Return ``{key: how it is read}`` of the numbers that a Typst text quotes, those by a shorthand of its own included."""
    text = without_comments(text)
    keys = {key: how for how, key in _READS.findall(text)}
    for short, how, prefix in _SHORT.findall(text):
        keys |= {prefix + key: how for key in re.findall(rf"\b{short}\(\s*\"([^\"]+)\"", text)}
    return keys


def picture_widths(text: str, page: float, column: float) -> dict[str, float]:
    """Return how wide each figure of a Typst text is printed, in the unit of the two widths given.

    Args:
        text: Of one file or several. page: Width of what floats over both columns. column: Of one column.
    """
    text = without_comments(text)
    widths = {}
    for found in _PICTURES.finditer(text):
        settings = re.match(r"(?:\s*,\s*(?:width: [\d.]+%|in-column: true))*", text[found.end() :])
        assert settings is not None
        share = re.search(r"width: ([\d.]+)%", settings[0])
        room = column if "in-column: true" in settings[0] else page
        widths[found[1]] = room * (float(share[1]) / 100.0 if share else 1.0)
    return widths


def pictures(text: str) -> list[str]:
    """Return the names of the figures that a Typst text shows."""
    return _PICTURES.findall(without_comments(text))
