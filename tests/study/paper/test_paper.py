"""The paper: each number in it has its key, none that it quotes may be missing, and the same inputs give the same bytes."""

import hashlib
import os
import re
import subprocess
import sys
from decimal import ROUND_HALF_EVEN, Decimal
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from study.paper.numbers import MOST_DIGITS, POWER, entry, gather, rounded, unit_of
from study.paper.parts import _workcells
from study.paper.typeset import typeset

from scalar.errors import InvalidInput
from tests.typst_text import pictures, quoted_keys, typed_numbers

ROOT = Path(__file__).parents[3]
PAPER = ROOT / "paper"
TEXTS = [path for path in sorted(PAPER.rglob("*.typ")) if path.name != "style.typ"]
LINE = '<svg xmlns="http://www.w3.org/2000/svg" width="400" height="{height}"><path d="M0 0 40 20" stroke="black"/></svg>'
PARTS = re.compile(r"#section\(\"(\w+)\", \"([^\"]+)\"")


@pytest.mark.parametrize("path", TEXTS, ids=lambda path: path.name)
def test_every_number_in_the_text_has_its_key(path):
    """A number is read from the results, or written beside its key and checked by the compiler; none stands alone."""
    assert typed_numbers(path.read_text(encoding="utf-8")) == []


@pytest.mark.parametrize("path", TEXTS, ids=lambda path: path.name)
def test_no_semicolon_is_swallowed(path):
    """No semicolon follows a call or a condition in prose, because Typst would take it as the end of that and not print it."""
    text = path.read_text(encoding="utf-8")
    assert not re.search(r"#\w+\((?:[^()]|\([^()]*\))*\);(?!;)", text)
    assert not re.search(r"\];(?!;)", text)


@pytest.mark.parametrize(
    "text",
    [
        "The error is 0.018 mm.",
        "falls by 5 times",
        "at 30°",
        '#figure(image("a.svg"), caption: [below 0.1 mm])',
        '#picture("a.svg", [Errors of 30 seeds.]) <fig-a>',
        "*strong 17*",
        'the #says("conventions.interval", "95 %") interval, and 7 more',
        "in thirty workcells",
        "leaning by three degrees",
        '#if has("x") [ of 96 % ]',
        "- an item with 4.8",
        "$sigma = 0.1$",
        "$N = 120$",
        "#table([a], [0.35])",
        '#text("0.35 mm")',
        'read #n("a.b"), typed 7',
        "= A heading of 12 words",
        "in twenty-six exams",
        "a twenty sided arm, the fourth",
    ],
)
def test_a_typed_number_is_found(text):
    """The check finds a number wherever one may be typed: in prose, captions, tables, headings, formulas and words in code."""
    assert len(typed_numbers(text)) == 1


@pytest.mark.parametrize(
    "text",
    [
        'is #n("headline.methods.proposed.raw.position_mean_mm.mean", digits: 3), and @fig-12 shows it',
        "$ f = 1/2 x_1^2 + T_(i-1,i) $ <eq-1>",
        "a Denso VS060 with a 2D scanner",
        "// 30 seeds\n/* 0.5 mm */ nothing",
        '#picture("figure-3.svg", width: 60%, [What to see.]) <fig-3>',
        "#set text(size: 9.6pt)\nthree planes",
        '`theta_6` and #name("held.7").',
        "as the nineteenth and the twenty-sixth exam did",
        'An interval of #says("conventions.interval", "95 %") holds #says("setup.seeds", "30") seeds.',
    ],
)
def test_what_is_no_number_is_left_alone(text):
    """The check accepts keys, labels, names, exponents and font sizes, which are no results."""
    assert typed_numbers(text) == []


@given(st.floats(min_value=1e-12, max_value=1e9), st.integers(1, MOST_DIGITS), st.booleans())
def test_rounding_agrees_with_decimal_arithmetic(size, digits, negative):
    """A text reads back as the number rounded to that many significant digits, half to even, of its exact value."""
    value = -size if negative else size
    text = rounded(value, digits).replace("−", "-").replace(",", "")
    mantissa, _, exponent = text.partition(POWER)
    exact = Decimal(value)
    step = Decimal(1).scaleb(exact.adjusted() - digits + 1)
    expected = exact.quantize(step, rounding=ROUND_HALF_EVEN)
    read = Decimal(mantissa).scaleb(int(exponent or 0))
    # Whole numbers of more digits than asked for, and mantissas, are rounded from a float: as near as that is.
    assert abs(read - expected) <= (step if abs(read - exact) <= step * Decimal("0.5000001") else 0)


@pytest.mark.parametrize(
    ("value", "digits", "text"),
    [(0.0184, 2, "0.018"), (0.1, 3, "0.100"), (14.6, 3, "14.6"), (9.99, 2, "10"), (96.666, 3, "96.7"), (0.0, 2, "0"),
     (12345.0, 5, "12,345"), (3.14e-6, 2, "3.1×10^−6"), (-0.5, 1, "−0.5"), (9.96e-6, 2, "1.0×10^−5")],
)  # fmt: skip
def test_numbers_look_as_in_print(value, digits, text):
    """Trailing zeros are kept, thousands are separated, and negative numbers have a minus sign, not a hyphen."""
    assert rounded(value, digits) == text


def test_units_come_from_names():
    """The nearest name with a unit gives it; a small length in metres is read in millimetres; whole numbers are exact."""
    content = {
        "position_mean_mm": {"mean": 0.0184, "seeds": 30},
        "size_m": 5e-4,
        "tilt_deg": 1.5,
        "within_2": 0.9613,
    }
    numbers = gather({"a": content})["numbers"]
    assert (
        numbers["a.position_mean_mm.mean"]["text"][1] + numbers["a.position_mean_mm.mean"]["unit"]
        == "0.018\u202fmm"
    )
    assert numbers["a.size_m"]["text"][0] + numbers["a.size_m"]["unit"] == "0.5\u202fmm"
    assert numbers["a.tilt_deg"]["unit"] == "°"
    assert numbers["a.within_2"]["percent"] == ["96", "96.1", "96.13"]
    assert unit_of("seeds") == unit_of("normalized_error_rms") == ""
    assert entry(4096, "")["text"] == ["4096"]


def test_lists_have_a_length_and_items():
    """The length of a list has a key, and its items have keys with their places, counted from one."""
    numbers = gather({"a": {"held": ["d_6", "theta_6"]}})["numbers"]
    assert (numbers["a.held.count"]["text"], numbers["a.held.2"]["text"]) == (["2"], ["theta_6"])


def test_one_key_for_two_numbers_is_refused():
    """A key that would mean two numbers stops the paper, by name."""
    with pytest.raises(InvalidInput, match=r"a\.b\.c"):
        gather({"a": {"b": {"c": 1}, "b.c": 2}})


def written(folder: Path, text: str) -> Path:
    """Return a folder with the paper's style and a text of one's own."""
    folder.mkdir(exist_ok=True)
    (folder / "style.typ").write_text((PAPER / "style.typ").read_text(encoding="utf-8"), encoding="utf-8")
    (folder / "paper.typ").write_text(
        '#import "style.typ": *\n#set document(date: auto)\n' + text, encoding="utf-8"
    )
    return folder


def test_a_missing_number_is_named(tmp_path):
    """A text that quotes what the results do not hold is not typeset, and the message has the key."""
    numbers = gather({"headline": {"error_mm": 0.5}, "setup": {"seeds": 30}})
    typeset(written(tmp_path / "good", '#n("headline.error_mm")'), numbers, {})
    with pytest.raises(InvalidInput, match=r"headline\.no_such_mm"):
        typeset(written(tmp_path / "bad", '#n("headline.no_such_mm")'), numbers, {})


@pytest.mark.parametrize(
    ("key", "right", "wrong"),
    [
        ("a.error_mm", "0.5 mm", "0.6 mm"),
        ("a.error_mm", "0.50", "0.5 m"),
        ("a.share", "95 %", "94 %"),
        ("a.share", "94.7 %", "95.0 %"),
        ("a.seeds", "30", "31"),
    ],
)
def test_a_written_number_is_checked_against_its_key(tmp_path, key, right, wrong):
    """Text and results say the same, in some rounding, or the text is not typeset and the message has both."""
    numbers = gather({"a": {"error_mm": 0.5, "share": 0.947, "seeds": 30}})
    typeset(written(tmp_path / "good", f'#says("{key}", "{right}")'), numbers, {})
    with pytest.raises(InvalidInput, match=rf"'{wrong}' where the results have '{re.escape(key)}'"):
        typeset(written(tmp_path / "bad", f'#says("{key}", "{wrong}")'), numbers, {})


def test_a_missing_figure_is_named(tmp_path):
    """A figure that is not among the results stops the paper, by name."""
    with pytest.raises(InvalidInput, match=r"no_such\.svg"):
        typeset(
            written(tmp_path / "bad", '#picture("no_such.svg", [x])'), gather({"setup": {"seeds": 3}}), {}
        )


def test_a_letter_that_no_font_has_is_refused(tmp_path):
    """The paper is never printed with boxes in the place of letters."""
    with pytest.raises(InvalidInput, match="could not be displayed"):
        typeset(
            written(tmp_path / "bad", "#set text(fallback: false)\n\u4e00"),
            gather({"setup": {"seeds": 3}}),
            {},
        )


def invented(tmp_path: Path, height: int = 200) -> tuple[dict[str, Any], dict[str, Path]]:
    """Return a number for every key that the text quotes, and a picture for every figure: enough to typeset all of it."""
    text = "\n".join(path.read_text(encoding="utf-8") for path in TEXTS)
    numbers = {key: entry("word" if how == "name" else 0.25, "") for key, how in quoted_keys(text).items()}
    for key in [key for key, how in quoted_keys(text).items() if how == "listed"]:
        numbers |= {f"{key}.count": entry(2, ""), f"{key}.1": entry("one", ""), f"{key}.2": entry("two", "")}
    numbers["setup.seeds"] = entry(30, "")
    line = tmp_path / "line.svg"
    line.write_text(LINE.format(height=height), encoding="utf-8")
    parts = [part for part, file in PARTS.findall(text) if (PAPER / file).exists()]
    return {"draft": True, "parts": parts, "numbers": numbers}, {name: line for name in pictures(text)}


def test_every_section_can_be_typeset(tmp_path):
    """With a number behind every key and a picture behind every figure, the whole text compiles, whatever the results."""
    numbers, figures = invented(tmp_path)
    (document,) = typeset(PAPER, numbers, figures)
    assert document.startswith(b"%PDF-")


def test_sentences_on_other_workcells_appear_only_with_their_numbers():
    """Sentences on other workcells have numbers in the default run, and small runs, which lack these numbers, leave the sentences out."""
    curves = {
        "offset_std": {"point": {"position_mean_mm": 0.2, "orientation_mean_deg": 0.1}},
        "other_workcells": {"near": {"position_mean_mm": -0.3}, "far": {"position_mean_mm": 0.4}},
    }
    times = {"position_mean": 4.8, "orientation_mean": 6.6}
    known = gather({"compared": {"workcells": _workcells(curves, times)}})["numbers"]
    text = "\n".join(path.read_text(encoding="utf-8") for path in TEXTS)
    quoted = {key for key in quoted_keys(text) if key.startswith("compared.workcells.")}
    assert quoted and quoted <= set(known)
    assert known["compared.workcells.published_in_std.position_mean"]["text"][1] == f"{np.log(4.8) / 0.2:.1f}"


@pytest.mark.slow
def test_same_bytes_whatever_the_machine(tmp_path):
    """The PDF depends on its inputs alone, and not on the time, the home folder, the time zone or the fonts of the machine."""
    numbers, figures = invented(tmp_path)
    (document,) = typeset(PAPER, numbers, figures)
    script = f"""
import sys; sys.path[:0] = [{str(ROOT)!r}, {str(ROOT / "workflow")!r}]
import hashlib
from pathlib import Path
from tests.study.paper.test_paper import PAPER, invented
from study.paper.typeset import typeset
print(hashlib.sha256(typeset(PAPER, *invented(Path({str(tmp_path)!r})))[0]).hexdigest())
"""
    environment = os.environ | {
        "HOME": str(tmp_path / "nobody"),
        "TZ": "Asia/Tokyo",
        "SOURCE_DATE_EPOCH": "1000000000",
    }
    ran = subprocess.run(
        [sys.executable, "-c", script],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert ran.returncode == 0, ran.stderr
    assert ran.stdout.strip() == hashlib.sha256(document).hexdigest()


def test_the_text_needs_no_network():
    """The text imports no package from Typst's server."""
    for path in [*TEXTS, PAPER / "style.typ"]:
        assert "@preview" not in path.read_text(encoding="utf-8")


def test_every_reference_is_cited():
    """What stands in the list of references is cited somewhere, and nothing is cited that is not there."""
    listed = set(
        re.findall(r"^@\w+\{(\w+),", (PAPER / "references.bib").read_text(encoding="utf-8"), re.MULTILINE)
    )
    text = "\n".join(path.read_text(encoding="utf-8") for path in TEXTS)
    cited = {key for key in re.findall(r"@([a-z]+\d{4})", text)}
    assert listed == cited


def test_the_readme_shows_what_is_committed():
    """Every figure in README and documentation is a small copy that `make readme-figures` refreshes."""
    pages = (ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")))
    text = "".join(page.read_text(encoding="utf-8") for page in pages)
    shown = re.findall(r"\((?:\.\./)?paper/figures/([^)]+)\)", text)
    copied = re.findall(r'"([\w.]+)": "', (PAPER / "refresh_figures.py").read_text(encoding="utf-8"))
    assert shown and set(shown) == set(copied) == {path.name for path in (PAPER / "figures").iterdir()}
    assert all((PAPER / "figures" / name).stat().st_size < 200_000 for name in shown)
