"""The bound of the mean error is drawn beside means, and lines of the methods are medians."""

import numpy as np
import pandas as pd
import pytest
from matplotlib.figure import Figure
from study.plots.sweep import BOUND_ROWS, draw_panel

QUANTITY = "position_mean_mm"
VALUES = (0.1, 1.0, 10.0)


def summary() -> pd.DataFrame:
    """Return rows of summary.csv: means a fifth above the medians; at the last value a fit of the proposed method is lost."""
    rows = []
    for value in VALUES:
        for method, size in ((BOUND_ROWS, 0.9), ("proposed", 1.0), ("baseline-clip", 3.0)):
            median = size * value
            rows.append(
                {"value": value, "method": method, "quantity": QUANTITY, "failed": 0, "median": median}
                | {"lost": int(method == "proposed" and value == VALUES[-1]), "mean": 1.2 * median}
                | {"p05": 0.5 * median, "p95": 2.0 * median}
            )
    return pd.DataFrame(rows)


def drawn(table: pd.DataFrame) -> dict[str, list[tuple[np.ndarray, np.ndarray]]]:
    """Return the points of the lines that a panel draws, by what is drawn."""
    ax = Figure().subplots()
    draw_panel(ax, table, pd.DataFrame(), ["proposed", "baseline-clip"], QUANTITY, "log")
    found: dict[str, list[tuple[np.ndarray, np.ndarray]]] = {"bound": [], "means": [], "lines": []}
    for line in ax.lines:
        marks = {"x": "means", "v": "small"}.get(str(line.get_marker()), "lines")
        kind = {"None": marks, ":": "bound"}.get(line.get_linestyle(), "lines")
        if len(line.get_xdata()) and kind != "small":
            found[kind].append((np.asarray(line.get_xdata()), np.asarray(line.get_ydata())))
    return found


def test_the_bound_of_a_mean_is_drawn_beside_means():
    """The bound is its mean over the seeds, and the crosses are the proposed method's means, where no fit failed or was lost."""
    found = drawn(summary())
    [(x, y)] = found["bound"]
    assert (list(x), list(y)) == (list(VALUES), pytest.approx([1.2 * 0.9 * v for v in VALUES]))
    [(x, y)] = found["means"]
    assert (list(x), list(y)) == (list(VALUES[:2]), pytest.approx([1.2 * v for v in VALUES[:2]]))
    assert [list(y) for _, y in found["lines"]] == [
        pytest.approx([size * v for v in VALUES]) for size in (1.0, 3.0)
    ]


def test_no_mean_is_drawn_where_there_is_no_bound():
    """Without a bound nothing is compared with it."""
    table = summary()
    assert drawn(table[table["method"] != BOUND_ROWS])["means"] == []
