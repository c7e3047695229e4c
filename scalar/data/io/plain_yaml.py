"""YAML as plain data: mappings, lists, text and numbers, without tags, anchors or aliases.

The scalars are those of YAML 1.2's core schema, so ``1e-4`` is a number and ``no`` is text. The document is
built straight from the parser's events, with the limits checked while they stream: no tag, no anchor and no
alias is ever followed, so a "billion laughs" bomb is refused at its first anchor. Every value remembers its
line, so that a fault found later can name the line.
"""

import math
import os
import re
import sys
from collections.abc import Iterator
from io import StringIO
from pathlib import Path
from typing import Any

from ruamel.yaml import YAML, events
from ruamel.yaml.error import MarkedYAMLError, YAMLError
from ruamel.yaml.representer import SafeRepresenter

from scalar.data.io.atomic import atomic_write, plain
from scalar.data.io.regular_file import read_regular_file
from scalar.errors import Fault, InvalidInput

MAX_BYTES = 1_000_000
MAX_DEPTH = 20
LARGEST = 1e100  # as in tables; the square of a number from 1e154 on is not finite, and integers beyond 1e308 do not fit into float64

Lines = dict[tuple[str | int, ...], int]
"""The line of every value, or of its key, by its path: ``("robot", "joints", 2, "alpha") -> 14``."""

_NULL = re.compile(r"~|null|Null|NULL|")
_BOOL = re.compile(r"true|True|TRUE|false|False|FALSE")
_INT = re.compile(r"[-+]?[0-9]+")
_BASED = re.compile(r"0o[0-7]+|0x[0-9a-fA-F]+")
_FLOAT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?")
_NOT_FINITE = re.compile(r"[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)")
_TEXT_KEYS = frozenset({"name", "source"})
"""Keys whose values are text in every file that SCALAR reads, even if YAML would read a number: 7113e31 may be a commit."""
_CHARACTER = re.compile(r"\\U([0-9a-fA-F]{8})")
_OPENED = ("while parsing a flow", "while scanning a quoted scalar", "while scanning a simple key")
"""How the parser begins to say that something was opened in one line and not closed, or had no colon, up to a later one."""
_NO_VALUE_HERE = "mapping values are not allowed here"
_LINE_END = re.compile(r"\r\n|\r|\n")
_MAX_DIGITS = 400  # no number needs more, and Python refuses to convert integers of several thousand digits


def resolve(text: str) -> bool | int | float | str | None:
    """Return the value of an unquoted scalar by YAML 1.2's core schema."""
    if _NULL.fullmatch(text):
        return None
    if _BOOL.fullmatch(text):
        return text[0] in "tT"
    if len(text) > _MAX_DIGITS:
        return text
    if _INT.fullmatch(text):
        return int(text)
    if _BASED.fullmatch(text):
        return int(text[2:], 8 if text[1] == "o" else 16)
    if _FLOAT.fullmatch(text):
        return float(text)
    if _NOT_FINITE.fullmatch(text):
        return float(text.replace(".", ""))
    return text


def has_half_character(text: str) -> bool:
    r"""Return whether a text holds a lone surrogate (``"\ud800"``), which cannot be written to a file."""
    return any("\ud800" <= character <= "\udfff" for character in text)


class _Builder:
    """Turns the events of one document into plain data; raises InvalidInput at the first that is refused."""

    def __init__(self, file: str, stream: Iterator[Any], text_keys: bool) -> None:
        self.file = file
        self.stream = stream
        self.text_keys = text_keys
        self.lines: Lines = {}

    def refuse(self, event: Any, message: str, path: tuple[str | int, ...] = ()) -> InvalidInput:
        return InvalidInput(Fault(self.file, message, event.start_mark.line + 1, join_path(path) or None))

    def next(self) -> Any:
        """Return the next event, refusing tags, anchors, aliases and second documents."""
        event = next(self.stream)
        if isinstance(event, events.AliasEvent) or getattr(event, "anchor", None):
            raise self.refuse(event, "anchors and aliases (& and *) are not accepted; write the value out")
        tag = getattr(event, "tag", None) or getattr(event, "ctag", None)
        if tag is not None and str(tag) not in ("", "None"):
            raise self.refuse(event, f"tags ({str(tag)!r}) are not accepted; write plain values")
        if has_half_character(getattr(event, "value", None) or ""):
            raise self.refuse(event, "holds half a character (a lone surrogate); write the text anew")
        return event

    def document(self) -> Any:
        """Return the value of the only document; None if there is none."""
        value = None
        seen = False
        while not isinstance(event := self.next(), events.StreamEndEvent):
            if isinstance(event, events.DocumentStartEvent):
                if seen:
                    raise self.refuse(
                        event, "a second document begins here (---); keep one document in each file"
                    )
                if event.tags:
                    raise self.refuse(event, "%TAG directives are not accepted; remove this line")
                value, seen = self.value(self.next(), (), 0), True
        return value

    def value(self, event: Any, path: tuple[str | int, ...], depth: int) -> Any:
        """Return the value that begins with `event`, whose place is `path`, inside `depth` collections."""
        self.lines.setdefault(path, event.start_mark.line + 1)
        if isinstance(event, events.ScalarEvent):
            return _scalar(event)
        if depth >= MAX_DEPTH:
            raise self.refuse(event, f"nested more than {MAX_DEPTH} deep; make the structure flatter")
        if isinstance(event, events.SequenceStartEvent):
            items: list[Any] = []
            while not isinstance(event := self.next(), events.SequenceEndEvent):
                items.append(self.value(event, (*path, len(items)), depth + 1))
            return items
        mapping: dict[str, Any] = {}
        while not isinstance(event := self.next(), events.MappingEndEvent):
            key = None
            if isinstance(event, events.ScalarEvent):
                key = _scalar(event) if self.text_keys else event.value
            if not isinstance(key, str):
                number = isinstance(event, events.ScalarEvent) and _FLOAT.fullmatch(event.value)
                hint = (
                    "write a decimal point, as in 0.68, if this follows a decimal comma"
                    if number
                    else "correct it"
                )
                raise self.refuse(event, f"a key that is not text; put it in quotes, or {hint}", path)
            if key in mapping:
                raise self.refuse(event, f"the key {key!r} stands here twice; remove one of the two", path)
            self.lines[(*path, key)] = event.start_mark.line + 1
            value = self.next()
            if (
                key in _TEXT_KEYS
                and isinstance(value, events.ScalarEvent)
                and _NULL.fullmatch(value.value) is None
            ):
                mapping[key] = value.value
            else:
                mapping[key] = self.value(value, (*path, key), depth + 1)
        return mapping


def _scalar(event: Any) -> bool | int | float | str | None:
    """Return the value of a scalar: text as it is written if it is quoted or a block, else resolved."""
    return event.value if event.style else resolve(event.value)


def join_path(path: tuple[str | int, ...]) -> str:
    """Return ``robot.joints[2].alpha`` for ``("robot", "joints", 2, "alpha")``."""
    text = "".join(f"[{key}]" if isinstance(key, int) else f".{key}" for key in path)
    return text.removeprefix(".")


def load_yaml_lines(path: str | os.PathLike[str]) -> tuple[Any, Lines]:
    """Return the plain data in the file `path`, and the line of every value in it.

    Raises:
        InvalidInput: the file cannot be read, is not UTF-8 or not YAML, is longer than 1 MB or nested more
            than 20 deep, or holds a tag, an anchor, an alias, a duplicate key or a second document.
    """
    path = Path(path)
    return parse_yaml(path.name, read_regular_file(path, MAX_BYTES))


def parse_yaml(file: str, raw: bytes, text_keys: bool = True) -> tuple[Any, Lines]:
    """Return the plain data in the content of a file, and the line of every value in it.

    Args:
        file: Name of the file, for messages.
        raw: Its content.
        text_keys: Whether a key that YAML reads as something else than text (``1.98:``) is refused; else it is kept as it is written.

    Raises:
        InvalidInput: as for `load_yaml_lines`.
    """
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = raw.count(b"\n", 0, error.start) + 1
        message = f"byte {error.start} is not UTF-8; save the file as UTF-8 text"
        raise InvalidInput(Fault(file, message, line)) from error
    builder = _Builder(file, YAML(typ="safe", pure=True).parse(StringIO(text)), text_keys)
    try:
        return builder.document(), builder.lines
    except MarkedYAMLError as error:
        raise InvalidInput(_not_yaml(file, text, error)) from error
    except (ValueError, OverflowError) as error:  # an escape that names no character
        wrong = (found for found in _CHARACTER.finditer(text) if int(found[1], 16) > sys.maxunicode)
        line = next((text.count("\n", 0, found.start()) + 1 for found in wrong), None)
        message = "an escape that names no character; the last character is \\U0010ffff"
        raise InvalidInput(Fault(file, message, line)) from error
    except YAMLError as error:
        message = f"not YAML ({' '.join(str(error).split())}); save it as plain text"
        raise InvalidInput(Fault(file, message)) from error


def _not_yaml(file: str, text: str, error: MarkedYAMLError) -> Fault:
    """Return the fault of a text that is no YAML, in the line that has to be corrected.

    A bracket, a quotation mark or a key without its colon shows only in a later line; the line in which it stands is the one to correct.
    """
    what = " ".join(filter(None, [error.context, error.problem]))
    mark = error.problem_mark or error.context_mark
    remedy = "indent with spaces, not with a tab" if r"'\t'" in what else "correct this place"
    if mark is None:
        return Fault(file, f"not YAML ({what}); {remedy}")
    if error.context_mark is not None and (error.context or "").startswith(_OPENED):
        if mark.line > error.context_mark.line:
            what += f" up to line {mark.line + 1}"
        mark = error.context_mark
    elif error.problem == _NO_VALUE_HERE and mark.line > 0 and _colons(text, mark.line) == 1:
        remedy = f"correct the indentation of this line, or a missing colon in line {mark.line}"
    return Fault(file, f"not YAML ({what}); {remedy}", mark.line + 1)


def _colons(text: str, line: int) -> int:
    """Return how many colons stand in a line, from 0."""
    return "".join(_LINE_END.split(text)[line : line + 1]).count(":")


def load_yaml(path: str | os.PathLike[str]) -> Any:
    """Return the plain data (dict, list, text, numbers, booleans, None) in the file `path`.

    Raises:
        InvalidInput: as for `load_yaml_lines`.
    """
    return load_yaml_lines(path)[0]


class _Representer(SafeRepresenter):
    """Writes text in quotes wherever it would read back as something else, and never an alias."""

    def ignore_aliases(self, data: Any) -> bool:
        return True

    def represent_text(self, data: str) -> Any:
        # A question mark may begin a key in a mapping of one line, and is then lost.
        quoted = not isinstance(resolve(data), str) or not data.isprintable() or data.startswith(("?", ":"))
        return self.represent_scalar("tag:yaml.org,2002:str", data, style='"' if quoted else None)

    def represent_number(self, data: float) -> Any:
        """Write ``1.0e-05``, which YAML 1.1 readers take for a number too, and not ``1e-05``."""
        if not math.isfinite(data):
            return self.represent_float(data)
        mantissa, e, exponent = repr(data).partition("e")
        text = mantissa if "." in mantissa else f"{mantissa}.0"
        return self.represent_scalar("tag:yaml.org,2002:float", text + e + exponent)


_Representer.add_representer(str, _Representer.represent_text)
_Representer.add_representer(float, _Representer.represent_number)


def dump_yaml(mapping: Any, path: str | os.PathLike[str]) -> None:
    """Write plain data to the file `path`, atomically; keys in the given order, floats exactly."""
    yaml = YAML(typ="safe", pure=True)
    yaml.Representer = _Representer
    yaml.default_flow_style = None  # the innermost lists and mappings on one line each
    yaml.sort_base_mapping_type_on_output = False  # pyright: ignore[reportAttributeAccessIssue]
    yaml.width = 160
    yaml.allow_unicode = True
    text = StringIO()
    yaml.dump(plain(mapping), text)
    with atomic_write(path) as temporary:
        temporary.write_text(text.getvalue(), encoding="utf-8", newline="\n")
