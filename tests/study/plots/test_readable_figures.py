"""Every figure can be read: no text below 6 pt where the paper shows it, none that stands on other text or reaches over the edge, no data cut off.

The width at which the paper shows a figure is read from its text; an index or an exponent counts with the text that it belongs to.
"""

import re

import pytest
from matplotlib.figure import Figure
from study.common.effect_words import case_words
from study.plots import blind_trials, measured
from study.plots.style import COLUMN_IN, PAGE_IN, new_figure, save_figure, styled

from tests.study.plots import readable
from tests.study.plots.drawn import DRAWN, ROOT, summary
from tests.typst_text import picture_widths

IN_PAPER = {
    "headline/errors": ("headline", "errors"),
    "headline/parameters": ("headline", "parameters"),
    "headline/singular_values": ("headline", "singular_values"),
    "headline/scene": ("scene", ""),
    "headline/workspace": ("workspace", ""),
    "headline/correlation": ("correlation", ""),
    "sweeps/overview_upright": ("sweeps", ""),
    "sequential/sequential": ("sequential", ""),
    "published_curves/curves": ("published curves", "curves"),
    "worked_example/worked_example": ("worked example", ""),
    "blind_trials/power": ("blind trials", "power"),
    "blind_trials/errors": ("blind trials", "errors"),
    "confidence/reliability": ("confidence", ""),
    "measured/gears": ("measured", "gears"),
    "sensitivity/sensitivity": ("sensitivity", ""),
    "edges/edges": ("edges", ""),
}
"""The figure drawn here for each that the paper shows; the others are looked at on a screen."""
TEXT = "\n".join(path.read_text(encoding="utf-8") for path in sorted((ROOT / "paper").rglob("*.typ")))
WIDTHS = picture_widths(TEXT, PAGE_IN, COLUMN_IN)
PRINTED = {IN_PAPER[name.removesuffix(".svg")]: width for name, width in WIDTHS.items()}
"""Width at which the paper shows a figure [in], as its text has it."""


def test_the_widths_are_those_of_the_page():
    """Page and column are what the style of the paper leaves of A4, and each figure that is measured is one that the paper shows."""
    style = (ROOT / "paper/style.typ").read_text(encoding="utf-8")
    margin, gutter = (
        float(re.findall(pattern, style)[0])
        for pattern in (r"margin = \(x: ([\d.]+)mm", r"gutter: ([\d.]+)mm")
    )
    assert pytest.approx((210.0 - 2 * margin) / 25.4, abs=0.005) == PAGE_IN
    assert pytest.approx((210.0 - 2 * margin - gutter) / 2 / 25.4, abs=0.005) == COLUMN_IN
    assert {f"{name}.svg" for name in IN_PAPER} == set(WIDTHS)


def test_a_width_is_read_from_the_text():
    """The width is read for a figure over the whole page, over a share of it, and in a column."""
    text = '#picture("a.svg", [x])\n#picture("b.svg", width: 50%, [x])\n#picture(\n  "c.svg", in-column: true,\n  [x])'
    assert picture_widths(text, 8.0, 3.0) == {"a.svg": 8.0, "b.svg": 4.0, "c.svg": 3.0}


def test_a_file_is_as_wide_as_its_figure(tmp_path):
    """The file that the paper shows has the width of the figure from which the sizes of type are scaled."""
    figure = flawed("")
    save_figure(figure, [tmp_path / "figure.svg"])
    written = re.search(
        r'<svg[^>]* width="([\d.]+)pt"', (tmp_path / "figure.svg").read_text(encoding="utf-8")
    )
    assert written is not None
    assert float(written[1]) / 72.0 == pytest.approx(figure.get_size_inches()[0], rel=1e-3)


@pytest.mark.parametrize("name", DRAWN)
def test_every_text_and_value_of_a_figure_is_visible(name):
    """The figure passes all checks, so that every text and every value in it can be seen."""
    for part, figure in DRAWN[name]().items():
        try:
            readable.assert_readable(figure, printed_in=PRINTED.get((name, part)))
        except AssertionError as error:
            raise AssertionError(f"{name} {part}: {error}") from None


def flawed(flaw: str) -> Figure:
    """Return a small figure with one flaw, or none."""
    with styled():
        figure = new_figure(4.0, 3.0)
        ax = figure.subplots()
        ax.plot([0.0, 1.0, 2.0], [1.0, 2.0, 3.0], "o")
        ax.set_xlabel("angle [°]")
        ax.text(1.0, 2.5, "one", fontsize=5.5 if flaw == "small" else 8)
        if flaw == "overlap":
            ax.text(1.02, 2.5, "two", fontsize=8)
        if flaw == "turned overlap":
            ax.set_xticks([0.0, 0.02], ["a long label", "another label"], rotation=45)
        if flaw == "outside":
            figure.text(0.97, 0.5, "beyond the edge")
        if flaw == "cut off":
            ax.set_ylim(0.0, 2.5)
        if flaw == "cut off bar":
            ax.bar([1.0], [9.0])
            ax.set_ylim(0.0, 5.0)
    return figure


@pytest.mark.parametrize(
    ("flaw", "finds"),
    [
        ("small", "small_texts"),
        ("overlap", "overlapping_texts"),
        ("turned overlap", "overlapping_texts"),
        ("outside", "texts_outside"),
        ("cut off", "data_outside"),
        ("cut off bar", "data_outside"),
    ],
)
def test_each_flaw_is_found_and_by_its_own_check(flaw, finds):
    """A figure without a flaw passes, and with a flaw exactly one check fails, so each check can fail."""
    readable.assert_readable(flawed(""))
    checks = ("small_texts", "overlapping_texts", "texts_outside", "data_outside")
    assert [name for name in checks if getattr(readable, name)(flawed(flaw))] == [finds]


def test_a_figure_of_the_summaries_shows_every_row():
    """The figure of the blind trials has a row for each case with its number of sets, and that of the measured sets has a bar for each number."""
    table = summary("blind_trials", "confusion")
    table = table[table["size"] >= 1.0]
    text = readable.words(blind_trials.draw_confusion(table))
    for case, rows in table.groupby("case"):
        assert f"{case_words(str(case))}  ({rows['count'].sum()})" in text
    errors = summary("measured", "errors")
    (ax,) = measured.draw_errors(errors).axes
    known = errors["model"].str.startswith(tuple(model for model, *_ in measured.MODELS))
    assert sorted(bar.get_height() for bar in ax.patches) == sorted(errors.loc[known, "held_out_rms_mm"])
