"""The figure of orders shows every way and case by name, from tables alone, also where a case has one pass only."""

import numpy as np
import pandas as pd
import pytest
from study.common.statistics import QUANTITIES
from study.plots.sequential import draw_sequential
from study.plots.style import LOOKS, save_figure
from study.sequential.compare import AT_ONCE, ORDERS, SEQUENTIAL_COLUMNS
from study.sequential.summary import summarise_sequential


def table(most: int) -> pd.DataFrame:
    """Return errors of four seeds and two cases, up to `most` passes in the first of them."""
    rng = np.random.default_rng(3)
    rows = []
    for case, last in (("first", most), ("second", 1)):
        noise = 0.1 if case == "first" else 0.7
        common = {
            "case": case,
            "poses": 60,
            "noise_mm": noise,
            "length_error_mm": 2.0,
            "angle_error_deg": 1.0,
        }
        for seed in range(4):
            walk = [("initial", 0), (AT_ONCE, 0), *((way, i + 1) for way in ORDERS for i in range(last))]
            for way, done in walk:
                key = {"seed": seed, "way": way, "passes": done, "last": done in (0, last), "status": ""}
                rows.append(
                    common | key | {"alignment": "raw"} | dict.fromkeys(QUANTITIES, rng.random() + 0.01)
                )
    return pd.DataFrame(rows).reindex(columns=list(SEQUENTIAL_COLUMNS))


@pytest.mark.parametrize("most", [1, 5])
def test_every_way_and_case_has_its_name(most):
    """The legend and the rows name every way and every case that is drawn, with units."""
    errors = table(most)
    figure = draw_sequential(errors, summarise_sequential(errors))
    figure.draw_without_rendering()
    text = " ".join(found.get_text() for found in figure.findobj(lambda a: hasattr(a, "get_text")))
    for word in (
        "at once",
        "scanner first",
        "as declared",
        "linear guess",
        "noise 0.1 mm",
        "noise 0.7 mm",
        "[mm]",
    ):
        assert word in text


def test_the_labels_of_the_rows_stand_nearer_to_their_own_panel():
    """Between the left panel and the labels of the rows of the right one, twice the size of the letters stays free."""
    errors = table(5)
    figure = draw_sequential(errors, summarise_sequential(errors))
    figure.draw_without_rendering()
    left, right = figure.axes
    for label in right.get_yticklabels():
        letters = label.get_fontsize() / 72 * figure.dpi
        assert label.get_window_extent().x0 - left.get_window_extent().x1 > 2 * letters


def test_the_initial_model_looks_as_in_the_other_figures():
    """The initial model has its own marker and colour, in both panels, and no way of calibration has them too."""
    errors = table(5)
    look, lines = (
        LOOKS["initial"],
        [line for ax in draw_sequential(errors, summarise_sequential(errors)).axes for line in ax.lines],
    )
    assert [line.get_marker() for line in lines if line.get_color() == look.colour] == [look.marker] * 3
    assert all(line.get_color() == look.colour for line in lines if line.get_marker() == look.marker)


def test_the_same_table_gives_the_same_bytes(tmp_path):
    """Files contain no date, no version and no random identifier."""
    errors = table(3)
    for name in ("one", "two"):
        figure = draw_sequential(errors, summarise_sequential(errors))
        save_figure(figure, [tmp_path / f"{name}.png", tmp_path / f"{name}.svg"])
    for suffix in ("png", "svg"):
        assert (tmp_path / f"one.{suffix}").read_bytes() == (tmp_path / f"two.{suffix}").read_bytes()
