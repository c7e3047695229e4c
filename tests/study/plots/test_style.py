"""The look of figures: a colour has one meaning and stands in one table, symbols are those of the text, labels keep their distance."""

import itertools
import re
from pathlib import Path

import pytest
import study.plots
from hypothesis import given
from hypothesis import strategies as st
from study.plots.style import COLOURS, LOOKS, rounded, spaced_labels, symbol

COLOUR = re.compile(r"[\"']#[0-9a-fA-F]{6}[\"']|color=[\"'](?!white|none)\w+[\"']")


def test_a_colour_stands_in_the_table_alone():
    """No other module of the figures names a colour except white, so that none gets a second meaning."""
    for path in Path(study.plots.__file__).parent.glob("*.py"):
        if path.name != "style.py":
            assert COLOUR.findall(path.read_text(encoding="utf-8")) == [], path.name


def test_a_colour_has_one_meaning():
    """All colours of the table differ, and the methods' are among them."""
    assert len(set(COLOURS.values())) == len(COLOURS)
    assert {look.colour for look in LOOKS.values()} <= set(COLOURS.values())


@pytest.mark.parametrize(
    ("value", "shown"),
    [
        (0.02996, "0.030"),
        (0.2, "0.20"),
        (0.0029, "0.0029"),
        (16.5, "16"),
        (17.2, "17"),
        (103.9, "104"),
        (1e-6, "1.0e-06"),
    ],
)
def test_a_result_keeps_the_zeros_at_its_end(value, shown):
    """A result is written with its two significant digits, as the text of the paper writes it."""
    assert rounded(value, 2) == shown


@pytest.mark.parametrize(
    ("name", "shown"),
    [
        ("a_2", "$a_{2}$"),
        ("alpha_4", r"$\alpha_{4}$"),
        ("beta_13", r"$\beta_{13}$"),
        ("sensor_x", "$x_{s}$"),
        ("sensor_rx", "$r_{x}$"),
        ("distance_wall_x", "$d$, wall x"),
        ("normal_floor_u", "$u$, floor"),
        ("joint_scale.3", "joint_scale.3"),
    ],
)
def test_parameters_have_symbols(name, shown):
    """Parameters have the symbols of the paper's text, and one without a symbol keeps its name."""
    assert symbol(name) == shown


@given(st.lists(st.floats(0, 1), min_size=2, max_size=20, unique=True), st.floats(0.01, 0.5))
def test_labels_keep_their_distance(places, least):
    """No two labels that are shown are nearer than asked for, except the two ends, which are always shown."""
    places = sorted(places)
    shown = spaced_labels(places, [f"{place}" for place in places], least)
    kept = [place for place, label in zip(places, shown, strict=True) if label]
    assert kept[0] == places[0] and kept[-1] == places[-1]
    assert all(b - a >= least for a, b in itertools.pairwise(kept)) or len(kept) == 2
