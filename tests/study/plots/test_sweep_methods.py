"""A method that one sweep alone has is drawn in the figure of this sweep, and not in the figure of all sweeps."""

import pandas as pd
import pytest
from study.common.methods import METHODS, TOLERANCE
from study.plots.style import LOOKS
from study.plots.sweep import draw_sweep
from study.plots.sweep_overview import draw_overview

from tests.study.plots.drawn import AXES, CURVES, sweep

LABEL = LOOKS[TOLERANCE].label


@pytest.fixture(scope="module")
def poses():
    """Return summary.csv of the sweep over the number of poses, with a line for the proposed method where the tolerance is stated."""
    table = sweep("poses")
    return pd.concat([table, table[table["method"] == "proposed"].assign(method=TOLERANCE)])


def labels(figure):
    """Return the entries of the legends of a figure."""
    return [text.get_text() for legend in figure.legends for text in legend.get_texts()]


def test_the_line_of_one_sweep_has_an_entry_and_a_strip_in_its_figure(poses):
    """Legend and strips of failures both name it, beside every other method."""
    figure = draw_sweep(poses, CURVES[CURVES["sweep"] == "poses"], "poses on three planes")
    assert {LABEL, *(LOOKS[name].label for name in METHODS)} <= set(labels(figure))
    strips = {text.get_text() for ax in figure.axes for text in ax.get_yticklabels()}
    assert LABEL.replace(" method", "") in strips


def test_the_figure_of_all_sweeps_shows_the_methods_that_all_have(poses):
    """The strips of failures stand side by side there, so that every panel needs the same ones."""
    figure = draw_overview({"noise": sweep("noise"), "poses": poses}, CURVES, AXES)
    assert LABEL not in labels(figure)
    assert {LOOKS[name].label for name in METHODS} <= set(labels(figure))
