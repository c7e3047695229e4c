"""The workcell, the correlations and the map of errors name what they show, and are the same bytes from the same tables."""

import numpy as np
import pandas as pd
import pytest
from matplotlib.image import imsave
from study.plots.correlation import draw_correlation, grouped
from study.plots.scene import draw_scene
from study.plots.style import save_figure, symbol
from study.plots.workspace import draw_workspace

NAMES = ["a_2", "theta_3", "d_4", "sensor_x", "normal_floor_u", "distance_floor", "joint_scale.3"]


def correlations() -> pd.DataFrame:
    """Return a correlation matrix with one strong pair."""
    matrix = np.eye(len(NAMES))
    matrix[0, 2] = matrix[2, 0] = -0.93
    return pd.DataFrame({"parameter": NAMES}).join(pd.DataFrame(matrix, columns=NAMES))


def errors() -> pd.DataFrame:
    """Return a map of three by three workcells, one of them missing, one with too few poses."""
    rng = np.random.default_rng(2)
    rows = [
        {"view": view, "u_m": 0.05 + 0.1 * i, "v_m": 0.05 + 0.1 * j, "poses": 1 if i == j == 0 else 9}
        | dict(zip(("before_mm", "after_mm", "predicted_mm"), rng.random(3) * [10, 0.1, 0.1], strict=True))
        for view in ("side", "above")
        for i in range(3)
        for j in range(3)
        if (i, j) != (1, 1)
    ]
    return pd.DataFrame(rows)


def words(figure) -> str:
    """Return all text of a figure."""
    figure.draw_without_rendering()
    return " ".join(text.get_text() for text in figure.findobj(lambda a: hasattr(a, "get_text")))


def test_parameters_are_grouped_and_none_is_lost():
    """The parameters are ordered by arm, scanner and planes; names that belong to none of these come last."""
    order, sizes = grouped(NAMES)
    assert sorted(order) == sorted(NAMES)
    assert list(sizes.values()) == [2, 1, 1, 2, 1]
    assert order[-1] == "joint_scale.3"


def test_strong_correlations_have_their_number():
    """The only strong correlation is written as a number, once."""
    text = words(draw_correlation(correlations()))
    assert text.count(".93") == 1
    assert all(symbol(name) in text for name in NAMES)


def test_the_map_has_units_and_states():
    """The map names each state and its unit, and says if there is no calibration at all."""
    text = words(draw_workspace(errors(), 5))
    for word in ("before", "found", "predicted", "[mm]", "[µm]", "5 repetitions"):
        assert word in text
    assert "no fit" in words(draw_workspace(errors().head(0), 0))


@pytest.mark.slow
def test_the_same_input_gives_the_same_bytes(tmp_path):
    """Files contain no date, no version and no random identifier, and the workcell's parts have their names."""
    picture = np.full((60, 80, 3), 255, dtype=np.uint8)
    picture[20:50, 10:70] = 90
    imsave(tmp_path / "picture.png", picture)
    places = {"floor": (30.0, 40.0), "scanner": (50.0, 30.0), "base": (40.0, 45.0)}
    for name in ("one", "two"):
        drawn = {
            "scene": draw_scene(tmp_path / "picture.png", places),
            "correlation": draw_correlation(correlations()),
            "workspace": draw_workspace(errors(), 5),
        }
        assert "floor" in words(drawn["scene"]) and "scanner" in words(drawn["scene"])
        for stem, figure in drawn.items():
            save_figure(figure, [tmp_path / name / f"{stem}.{suffix}" for suffix in ("png", "svg")])
    for path in (tmp_path / "one").iterdir():
        assert path.read_bytes() == (tmp_path / "two" / path.name).read_bytes()
