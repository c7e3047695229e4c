"""No parts of the paper overlap or reach over a margin, by the boxes of the typesetter; small pages with a fault are found."""

import re

import pytest
from study.paper.layout import boxes, layout_faults
from study.paper.numbers import gather
from study.paper.typeset import placed

from scalar.errors import InvalidInput
from tests.study.paper.test_paper import PAPER, invented, written

PAGE = {"left": 50.0, "top": 50.0, "right": 550.0, "bottom": 780.0}
NUMBERS = gather({"setup": {"seeds": 30}}) | {"draft": True}
HEAD = "#show: paper.with(title: [T], authors: [A], abstract: [B])\n"


def corners(what, page, left, top, right, bottom, last_page=None, height=0.0):
    """Return the marks of a box."""
    end = {"what": what, "corner": "end", "page": last_page or page, "x": right, "y": bottom}
    return [{"what": what, "corner": "start", "page": page, "x": left, "y": top}, end | {"height": height}]


def test_boxes_side_by_side_are_no_fault():
    """Boxes that touch, and boxes on different pages, do not overlap."""
    marks = [PAGE, *corners("a", 1, 50, 50, 300, 400), *corners("b", 1, 300, 50, 550, 400)]
    marks += corners("c", 1, 50, 400, 550, 780) + corners("d", 2, 50, 50, 550, 780)
    assert layout_faults(marks) == []


@pytest.mark.parametrize(
    ("marks", "words"),
    [
        (corners("a", 1, 50, 50, 300, 400) + corners("b", 1, 290, 390, 400, 500), "a and b overlap"),
        (corners("a", 1, 50, 50, 560, 400), "over the margin"),
        (corners("a", 1, 50, 600, 300, 790), "over the margin"),
        (corners("a", 1, 50, 600, 300, 100, last_page=2), "over the margin"),
        (corners("a", 1, 50, 600, 300, 700, height=130.0), "30 pt are cut off"),
        ([{"what": "a table", "page": 3, "width": 260.0, "room": 240.0}], "20 pt wider"),
    ],
)
def test_each_fault_is_found(marks, words):
    """Each fault gives one sentence, which names the page."""
    (fault,) = layout_faults([PAGE, *marks])
    assert words in fault and fault.startswith("page ")


def test_equal_names_pair_with_their_own_corners():
    """Boxes with the same name, as all tables have, are made of the corners that belong together."""
    marks = corners("a table", 1, 50, 50, 100, 100) + corners("a table", 1, 50, 200, 100, 300)
    assert [(box.top, box.bottom) for box in boxes(marks)] == [(50, 100), (200, 300)]


def test_the_typesetter_tells_where_things_are(tmp_path):
    """A block of a known size at the start of a column has that size, and one that is moved onto it is found."""
    block = '#boxed("one", rect(width: 100%, height: 40mm))\n'
    over = '#place(top, boxed("two", rect(width: 20mm, height: 10mm)))\n'
    marks = placed(written(tmp_path / "good", HEAD + block), NUMBERS, {})
    (box,) = boxes([mark for mark in marks if "corner" in mark])
    assert box.bottom - box.top == pytest.approx(40 * 72 / 25.4, abs=0.1)
    assert layout_faults(marks) == []
    faults = layout_faults(placed(written(tmp_path / "over", HEAD + over + block * 4), NUMBERS, {}))
    assert any("overlap" in fault for fault in faults)


@pytest.mark.parametrize(
    "text",
    [
        '#boxed("tall", rect(width: 100%, height: 300mm))',
        "$ " + " + ".join(["alpha_(i j)"] * 40) + " $",
        "#table(columns: (60mm, 60mm), [a], [b])",
    ],
    ids=["tall", "formula", "table"],
)
def test_what_is_too_large_is_found(tmp_path, text):
    """A box that is taller than the page, and a formula and a table that are wider than their column, are found."""
    assert layout_faults(placed(written(tmp_path / "large", HEAD + text), NUMBERS, {})) != []


@pytest.mark.parametrize("aspect", [0.35, 0.75])
def test_no_page_of_the_paper_hides_anything(tmp_path, aspect):
    """With a number behind every key and figures of several shapes, all of the text is laid out without a fault."""
    numbers, figures = invented(tmp_path, height=round(400 * aspect))
    assert layout_faults(placed(PAPER, numbers, figures)) == []


def test_a_page_with_a_fault_is_refused(tmp_path):
    """What hides something stops the paper, with its page and its names; a draft may."""
    from study.paper.typeset import write_paper

    text = written(tmp_path / "bad", HEAD + '#boxed("tall", rect(width: 100%, height: 300mm))')
    with pytest.raises(InvalidInput, match=r"of tall \d+ pt are cut off"):
        write_paper(tmp_path / "paper.pdf", text, NUMBERS | {"draft": False, "parts": []}, {})
    assert not (tmp_path / "paper.pdf").exists()
    write_paper(tmp_path / "paper.pdf", text, NUMBERS, {})
    assert (tmp_path / "paper.pdf").exists()


def test_no_text_of_a_table_is_below_6_pt():
    """A commit or an exponent in a table, the smallest text that has them, is no smaller than 6 pt; Typst gives code four fifths of its text."""
    style = (PAPER / "style.typ").read_text(encoding="utf-8")
    (table,) = re.findall(r"figure\.where\(kind: table\): set text\(([\d.]+)pt\)", style)
    (code,) = re.findall(r"show raw: set text\([^)]*size: ([\d.]+)em", style)
    (exponent,) = re.findall(r"set super\(size: ([\d.]+)em\)", style)
    assert 0.8 * float(code) * float(table) >= 6.0
    assert float(exponent) * float(table) >= 6.0
