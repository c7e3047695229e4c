"""YAML reads as plain YAML 1.2 data, writes so that it reads back, and refuses whatever could do harm."""

import math
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from ruamel.yaml import YAML

from scalar.data.io.plain_yaml import _TEXT_KEYS, MAX_DEPTH, dump_yaml, load_yaml, load_yaml_lines
from scalar.errors import InvalidInput

LEAVES = (
    st.none()
    | st.booleans()
    | st.integers(-(2**70), 2**70)
    | st.floats(allow_nan=False)
    | st.text(max_size=12)
)
# The values of _TEXT_KEYS are always text.
KEYS = st.text(max_size=8).filter(lambda key: key not in _TEXT_KEYS)
DATA = st.recursive(
    LEAVES,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(KEYS, inner, max_size=4),
    max_leaves=12,
)
IN_ONE_FOLDER = settings(suppress_health_check=[HealthCheck.function_scoped_fixture])


def load_text(folder: Path, text: str | bytes) -> Any:
    """Return what the text of a file reads as."""
    path = folder / "in.yaml"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return load_yaml(path)


@IN_ONE_FOLDER
@given(DATA)
@example({":0": None})
def test_what_is_written_reads_back(tmp_path: Path, data: Any) -> None:
    """``load(dump(x)) == x`` holds, types and bits of floats included."""
    dump_yaml({"data": data}, tmp_path / "a.yaml")
    back = load_yaml(tmp_path / "a.yaml")
    assert repr(back) == repr({"data": data})


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1e-4", 1e-4), ("-1E+3", -1000.0), (".5", 0.5), ("5.", 5.0), ("+3", 3), ("0x1F", 31), ("0o17", 15),
        ("017", 17), ("no", "no"), ("on", "on"), ("true", True), ("~", None), ("", None), ("'1'", "1"),
        ("1_000", "1_000"), ("12:30", "12:30"), ("2001-01-01", "2001-01-01"), ("-.inf", -math.inf),
        ("1e-4m", "1e-4m"),
    ],
)  # fmt: skip
def test_scalars_are_those_of_the_core_schema(tmp_path: Path, text: str, value: Any) -> None:
    """By YAML 1.2, chapter 10.3, 1e-4 is a number, and no, on, times and dates are text, even under %YAML 1.1."""
    assert repr(load_text(tmp_path, f"a: {text}")) == repr({"a": value})
    assert repr(load_text(tmp_path, f"%YAML 1.1\n---\na: {text}")) == repr({"a": value})


@given(st.floats(allow_nan=False, allow_infinity=False))
@IN_ONE_FOLDER
def test_floats_are_numbers_for_yaml_1_1_readers_too(tmp_path: Path, x: float) -> None:
    """Another reader, told to take the file for YAML 1.1, finds the same float."""
    dump_yaml({"x": x}, tmp_path / "a.yaml")
    other = YAML(typ="safe", pure=True)
    other.version = (1, 1)  # pyright: ignore[reportAttributeAccessIssue]
    assert repr(other.load(tmp_path / "a.yaml")["x"]) == repr(x)


BOMB = "a: &a [x, x]\nb: &b [*a, *a]\nc: [*b, *b]\n"


@pytest.mark.parametrize(
    ("text", "row", "word"),
    [
        (BOMB, 1, "anchors"), ("a: *x", 1, "aliases"),
        ("a: 1\nb: !!python/object/apply:os.system [x]", 2, "tags"),
        ("a: !x 1", 1, "tags"), ("a: ! 1", 1, "tags"), ("%TAG ! x:\n---\na: 1", 2, "%TAG"),
        ("a: 1\na: 2", 2, "twice"),
        ("a: 1\n--- \nb: 2", 2, "second document"), ("1: a", 1, "not text"), ("? [a]\n: b", 1, "not text"),
        ("a: [1,\n", 2, "not YAML"), ("a: b: c", 1, "not YAML"), ("a:\n\tb: 1", 2, "not YAML.*spaces, not with a tab"),
        ("a: \x01", None, "not YAML"),
        ("[" * 100_000, 1, "deep"), ("- " * 50 + "a", 1, "deep"), (b"a: 1\nb: \xff", 2, "UTF-8"),
        ("a: 1\n".encode("utf-16"), 1, "UTF-8"), ("# " + "x" * 1_000_000, None, "1 MB"),
    ],
)  # fmt: skip
def test_harmful_and_broken_files_are_refused(
    tmp_path: Path, text: str | bytes, row: int | None, word: str
) -> None:
    """Tags, anchors, duplicate keys, great depth or length and broken syntax raise InvalidInput, with the line."""
    with pytest.raises(InvalidInput, match=word) as caught:
        load_text(tmp_path, text)
    assert [fault.row for fault in caught.value.faults] == [row]
    assert row is None or f"in.yaml, line {row}" in str(caught.value)
    assert len(str(caught.value).splitlines()) == 1


@pytest.mark.parametrize("end", ["\n", "\r\n"])
@pytest.mark.parametrize(
    ("lines", "at", "word"),
    [
        (["a: 1", "b: {x: [1, 2}", "c: 3"], 2, "not YAML"),
        (["a: 1", "b: {x: 1", "c: 3", "d: 4"], 2, "up to line 3"),
        (["a: 1", "b: [1,", "  2,", "  3", "c: 4"], 2, "up to line 5"),
        (["a: 1", "b", "c: 3"], 2, "could not find expected ':'"),
        (["a: 1", "b: 'x", "c: 3"], 2, "quoted"),
        (["a:", "  b 1", "  c: 2"], 3, "indentation of this line, or a missing colon in line 2"),
        (["# a comment", "", "a: 1", "a: 2"], 4, "twice"),
    ],
)
def test_the_line_to_correct_is_named(tmp_path: Path, lines: list[str], at: int, word: str, end: str) -> None:
    """What is opened and not closed is named in the line in which it stands, although it shows only in a later one."""
    with pytest.raises(InvalidInput, match=word) as caught:
        load_text(tmp_path, (end.join(lines) + end).encode())
    assert f"in.yaml, line {at}" in str(caught.value)


def test_the_greatest_depth_is_accepted(tmp_path: Path) -> None:
    """A file nested as deep as the limit is read, and one nested one level deeper is refused."""
    assert load_text(tmp_path, "[" * MAX_DEPTH + "]" * MAX_DEPTH)
    with pytest.raises(InvalidInput, match="deep"):
        load_text(tmp_path, "[" * (MAX_DEPTH + 1) + "]" * (MAX_DEPTH + 1))


@IN_ONE_FOLDER
@given(st.binary(max_size=60) | st.text("{}[]:,-#&*!|>'\"%@` \n\tab1.", max_size=40).map(str.encode))
def test_any_bytes_are_read_or_refused(tmp_path: Path, raw: bytes) -> None:
    """Any bytes give either plain data or InvalidInput."""
    try:
        load_text(tmp_path, raw)
    except InvalidInput as error:
        assert error.faults[0].file == "in.yaml"


def test_a_missing_file_and_a_folder_are_refused(tmp_path: Path) -> None:
    """No file, or a folder in its place, is the user's fault and not a traceback."""
    for path in (tmp_path / "none.yaml", tmp_path):
        with pytest.raises(InvalidInput, match="cannot be read"):
            load_yaml(path)


def test_values_have_their_lines(tmp_path: Path) -> None:
    """The line of a value is that of its key, or of its dash in a list."""
    (tmp_path / "a.yaml").write_text("# comment\na:\n  - b: 1\n    c:\n      [1,\n      2]\n  - d\n")
    lines = load_yaml_lines(tmp_path / "a.yaml")[1]
    assert lines["a",] == 2
    assert lines["a", 0, "b"] == 3
    assert lines["a", 0, "c"] == 4
    assert lines["a", 0, "c", 1] == 6
    assert lines["a", 1] == 7


@pytest.mark.parametrize("name", ["7", "7113e31", "532737e985", "true", "2026-11-21"])
def test_a_name_is_text_even_where_it_reads_like_something_else(tmp_path: Path, name: str) -> None:
    """Names and sources are text, even where YAML would read a number, such as an infinite one."""
    path = tmp_path / "a.yaml"
    path.write_text(f"name: {name}\nnoise: 1e-4\n", encoding="utf-8")
    assert load_yaml(path) == {"name": name, "noise": 1e-4}


@pytest.mark.parametrize("name", ["?0", "?;", "?", "? a"])
def test_a_text_that_begins_with_a_question_mark_reads_back(tmp_path: Path, name: str) -> None:
    """A question mark announces a key in YAML; as the first letter of a text it is part of the text."""
    dump_yaml({"data": {name: name}}, tmp_path / "a.yaml")
    assert load_yaml(tmp_path / "a.yaml") == {"data": {name: name}}
