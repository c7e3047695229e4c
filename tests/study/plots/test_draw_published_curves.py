"""The figure of the candidates for the published curves states sizes in the units of the other figures."""

import pandas as pd
import pytest
from study.plots.published_curves import draw_support

from tests.study.plots.drawn import candidates


@pytest.mark.parametrize(
    ("unit", "text"),
    [("mrad", "1° (0.5°"), ("mm", "17 mm (8.7"), ("share", "17 σ (8.7"), ("factor", "17 × σ (8.7")],
)
def test_angles_are_degrees_and_other_units_stay(unit, text):
    """A size of 17.45 mrad is a degree."""
    table: pd.DataFrame = candidates().head(1)
    sizes = {"magnitude_1": "spread", "unit_1": unit, "value_1": 17.4533, "low_1": 8.72665, "high_1": 34.9066}
    figure = draw_support(table.assign(**sizes))
    said = [item.get_text() for ax in figure.axes for item in (*ax.texts, *ax.get_yticklabels())]
    assert any(text.replace("° (0.5°", "° (0.5") in one for one in said), said
