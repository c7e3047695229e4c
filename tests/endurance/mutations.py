"""Good files, damaged at random: bytes, lines, words, cells, and parts of a tree."""

from __future__ import annotations

import json
import random
import re
from collections.abc import Callable
from typing import Any

WORDS = [
    b"", b"0", b"-0.0", b"1", b"-1", b"1e308", b"-1e308", b"1e-320", b"1e400", b"nan", b"-inf", b".inf", b".nan", b"null", b"~", b"true",
    b"[]", b"{}", b'""', b"1" * 390, b"1" * 5000, b"0x10", b"1_000", b"1,5", b"1.0", b"abc", "\N{ARABIC-INDIC DIGIT THREE}".encode(),
    "\u202e".encode(), b'"\\ud800"', b'"\\U00110000"', b"\x00", b"\x1b[2J", b"&a", b"*a", b"!!python/object:os.system", b"<<", b"---", b"..",
    b"../../etc/passwd", b"/dev/zero", b"x" * 300, b"[" * 60, b"{a: " * 60, b"- " * 60,
]  # fmt: skip
VALUES: list[Any] = [
    None, True, False, 0, 1, -1, 2, 7, 99, 10**9, 10**400, 0.0, -0.0, 1e-320, 1e308, -1e308, float("nan"), float("inf"), "", "x", "floor",
    "1", "../../x", "\u202e", "\x1b[2J", "\ud800", "y" * 400, [], {}, [0], [0, 0, 0], [[1]], {"a": 1}, [None], ["x"], {"": {}}, [1e308] * 3,
]  # fmt: skip
_WORD = re.compile(rb"[^\s,:\[\]{}<>=\"']+")
_NUMBER = re.compile(rb"-?[0-9]+(\.[0-9]+)?(e[-+]?[0-9]+)?")
_WINDOW = 20_000  # bytes of a file that are searched for words and numbers


def mutated(raw: bytes, rng: random.Random) -> bytes:
    """Return the bytes of a file with one to three things wrong in it."""
    for _ in range(rng.choice((1, 1, 1, 2, 3))):
        raw = rng.choice(_WAYS)(raw, rng)
    return raw


def _bytes(raw: bytes, rng: random.Random) -> bytes:
    start = rng.randint(0, len(raw))
    end = min(len(raw), start + rng.choice((0, 1, 1, 4, 20, 200)))
    return raw[:start] + rng.randbytes(rng.choice((0, 1, 1, 4, 20))) + raw[end:]


def _bit(raw: bytes, rng: random.Random) -> bytes:
    if not raw:
        return b"\x00"
    at = rng.randrange(len(raw))
    return raw[:at] + bytes([raw[at] ^ (1 << rng.randrange(8))]) + raw[at + 1 :]


def _cut(raw: bytes, rng: random.Random) -> bytes:
    return raw[: rng.randint(0, len(raw))]


def _lines(raw: bytes, rng: random.Random) -> bytes:
    lines = raw.split(b"\n")
    i, j = rng.randrange(len(lines)), rng.randrange(len(lines))
    match rng.randrange(5):
        case 0:
            del lines[i]
        case 1:
            lines.insert(j, lines[i])
        case 2:
            lines[i], lines[j] = lines[j], lines[i]
        case 3:
            lines[i : i + 1] = [lines[i]] * 200
        case _:
            lines[i] = lines[i][: rng.randint(0, len(lines[i]))]
    return b"\n".join(lines)


def _columns(raw: bytes, rng: random.Random) -> bytes:
    """Exchange, repeat or remove a column of a table, or give all cells of one the same content; other files get another word."""
    rows = [line.split(b",") for line in raw.split(b"\n")]
    width = len(rows[0])
    if width < 2:
        return _word(raw, rng)
    i, j, what, word = rng.randrange(width), rng.randrange(width), rng.randrange(5), rng.choice(WORDS)
    for k, row in enumerate(rows):
        if len(row) != width:
            continue
        match what:
            case 0:
                row[i], row[j] = row[j], row[i]
            case 1:
                row.insert(j, row[i])
            case 2:
                del row[i]
            case 3 if k:
                row[i] = word
            case 4 if not k:
                row[i] = row[j]
            case _:
                pass
    return b"\n".join(b",".join(row) for row in rows)


def _found(pattern: re.Pattern[bytes], raw: bytes, rng: random.Random) -> list[re.Match[bytes]]:
    """Return where a pattern occurs, in a file that is long in a part of it that is drawn."""
    start = rng.randint(0, max(len(raw) - _WINDOW, 0))
    return list(pattern.finditer(raw, start, start + _WINDOW))


def _word(raw: bytes, rng: random.Random) -> bytes:
    found = _found(_WORD, raw, rng)
    if not found:
        return raw + rng.choice(WORDS)
    at = rng.choice(found)
    new = rng.choice(WORDS) if rng.random() < 0.7 else rng.choice(found)[0]
    return raw[: at.start()] + new + raw[at.end() :]


def _number(raw: bytes, rng: random.Random) -> bytes:
    found = _found(_NUMBER, raw, rng)
    if not found:
        return raw
    at = rng.choice(found)
    scale = rng.choice((-1.0, 0.0, 1e-3, 57.29577951308232, 1e3, 1e6, 1e12, 1e100))
    try:
        new = repr(float(at[0]) * scale).encode()
    except (OverflowError, ValueError):
        new = b"1"
    return raw[: at.start()] + new + raw[at.end() :]


def _tree(raw: bytes, rng: random.Random) -> bytes:
    """Replace, remove or repeat a part of a JSON file; other files get another word."""
    if not raw.lstrip().startswith(b"{"):
        return _word(raw, rng)
    try:
        content = json.loads(raw)
    except (ValueError, RecursionError):
        return _word(raw, rng)
    where: Any = content
    while isinstance(where, dict | list) and where:
        key: Any = rng.choice(list(where)) if isinstance(where, dict) else rng.randrange(len(where))
        inner = where[key]
        if not (isinstance(inner, dict | list) and inner) or rng.random() < 0.25:
            match rng.randrange(4):
                case 0:
                    del where[key]
                case 1 if isinstance(where, list):
                    where.insert(key, inner)
                case 1:
                    where[rng.choice(("x", "name", f"{key}x"))] = inner
                case _:
                    where[key] = rng.choice(VALUES)
            break
        where = inner
    return json.dumps(content, indent=1).encode("utf-8", errors="surrogatepass")


_WAYS: tuple[Callable[[bytes, random.Random], bytes], ...] = (
    _bytes, _bit, _cut, _lines, _lines, _columns, _columns, _word, _word, _word, _number, _number, _tree, _tree, _tree, _tree,
)  # fmt: skip
