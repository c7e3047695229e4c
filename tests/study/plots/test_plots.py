"""Figures come from tables alone, name everything they show, and are the same bytes from the same tables."""

import ast
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import study.plots
from matplotlib.figure import Figure
from study.common.methods import INITIAL, METHODS
from study.common.statistics import QUANTITIES
from study.headline.summary import place_published, summarise_errors, summarise_parameters
from study.plots.errors import draw_errors
from study.plots.identifiability import draw_singular_values
from study.plots.initial import draw_initial
from study.plots.parameters import draw_parameters
from study.plots.planes import draw_planes
from study.plots.style import LOOKS, PUBLISHED, numeral, save_figure, with_unit

PLANES = ("floor", "wall_x")
PARAMETERS = (("a_2", "mm"), ("sensor_x", "mm"), ("alpha_3", "deg"))
STATED = pd.DataFrame({"state": ["initial", "calibrated"], **{q: [14.6, 0.0887] for q in QUANTITIES}})
PLANE_CLAIM = pd.DataFrame({"distance_error_mm": [0.1], "normal_error_deg": [0.01]})


def tables() -> dict[str, pd.DataFrame]:
    """Return tables of every method over five seeds; one method failed in each."""
    rng = np.random.default_rng(5)
    errors, planes, parameters = [], [], []
    for seed in range(5):
        for method in (INITIAL, *METHODS):
            status = {INITIAL: INITIAL, "baseline-raise": "raised"}.get(method, "converged")
            key = {"case": "a", "seed": seed, "method": method, "status": status}
            sizes = dict(zip(QUANTITIES, rng.random(4) + 0.01, strict=True))
            errors += [key | {"alignment": alignment} | sizes for alignment in ("raw", "aligned")]
            for plane in PLANES:
                size = 0.0 if method == "baseline-clip" else rng.random() / 10
                planes.append(key | {"plane": plane, "normal_error_deg": size, "distance_error_mm": -size})
            for parameter, unit in PARAMETERS:
                std = np.nan if status != "converged" else 0.1
                row = {"parameter": parameter, "unit": unit, "truth": 0.0, "error": rng.normal() / 10}
                normalized = row["error"] / std
                parameters.append(key | row | {"std": std, "normalized_error": normalized})
    return {
        "errors": pd.DataFrame(errors),
        "planes": pd.DataFrame(planes),
        "parameters": pd.DataFrame(parameters),
    }


def figures() -> dict[str, Figure]:
    """Return every figure that is drawn of a study."""
    given = tables()
    errors, parameters = given["errors"], given["parameters"]
    values = pd.DataFrame({"index": [1, 2, 3], "singular_value": [1.0, 0.1, 0.0], "tolerance": 1e-8})
    values["null"] = values["singular_value"] < 1e-8
    directions = pd.DataFrame({"held": ["d_2"]})
    of_parameters = summarise_parameters(parameters)
    return {
        "errors": draw_errors(errors, summarise_errors(errors), STATED),
        "initial": draw_initial(errors, place_published(errors, STATED)),
        "planes": draw_planes(given["planes"], PLANE_CLAIM),
        "parameters": draw_parameters(parameters, of_parameters, "proposed"),
        "without_errors": draw_parameters(parameters, of_parameters, "baseline-raise"),
        "singular_values": draw_singular_values(values, directions),
    }


def words(figure: Figure) -> str:
    """Return all text of a figure."""
    figure.draw_without_rendering()
    return " ".join(text.get_text() for text in figure.findobj(lambda a: hasattr(a, "get_text")))


@pytest.mark.slow
def test_the_same_tables_give_the_same_bytes(tmp_path):
    """Files contain no date, no version and no random identifier."""
    for name in ("one", "two"):
        for stem, figure in figures().items():
            save_figure(figure, [tmp_path / name / f"{stem}.{suffix}" for suffix in ("png", "svg", "pdf")])
    one = sorted((tmp_path / "one").iterdir())
    assert len(one) == 3 * len(figures())
    for path in one:
        assert path.read_bytes() == (tmp_path / "two" / path.name).read_bytes(), path.name


def test_every_axis_names_its_quantity_and_unit():
    """Every axis has a label with a unit, unless it shows counts or ratios."""
    for name, figure in figures().items():
        for axes in figure.axes:
            label = axes.get_ylabel()
            dimensionless = ("share of", "error / standard error", "singular value / largest")
            named = "[" in label or label.startswith(dimensionless)
            assert named or (name == "initial" and "[" in axes.get_xlabel()), (name, label)


def test_the_papers_values_stand_in_the_figures():
    """The published values are written as numbers into the figures that compare with them."""
    drawn = figures()
    assert {"14.6", "published 0.0887"} <= {
        t.get_text() for t in drawn["errors"].findobj() if hasattr(t, "get_text")
    }
    assert "published 14.6 mm" in words(drawn["initial"])
    assert "within 0.1 mm" in words(drawn["planes"])
    assert "within 0.01°" in words(drawn["planes"])


def test_failed_fits_are_said():
    """A method whose fits failed says how many of how many."""
    assert "5 of 5 failed" in " ".join(words(figures()["errors"]).split())
    assert "no fit gave standard errors" in words(figures()["without_errors"])


def test_a_plane_that_never_moved_is_still_drawn():
    """An error of exactly zero does not fall off a log axis."""
    figure = figures()["planes"]
    drawn = [line for line in figure.axes[0].lines if line.get_marker() == LOOKS["baseline-clip"].marker]
    assert sum(len(line.get_ydata()) for line in drawn) == 5 * len(PLANES)
    low = figure.axes[0].get_ylim()[0]
    assert all(np.min(line.get_ydata()) > low for line in drawn)


def test_every_method_has_a_look_of_its_own():
    """Methods have different colours and different markers, so that either is enough to distinguish them."""
    looks = [LOOKS[name] for name in (INITIAL, *METHODS)]
    for part in ("label", "colour", "marker"):
        assert len({getattr(look, part) for look in looks}) == len(looks)


def test_a_published_point_is_a_black_dot_in_every_figure():
    """The published errors of initial models are drawn as the published points of the sweeps are; crosses are left to fits that failed."""
    figure = draw_errors(tables()["errors"], summarise_errors(tables()["errors"]), STATED)
    black = [
        line
        for ax in figure.axes
        for line in ax.lines
        if line.get_color() == PUBLISHED and line.get_marker() != "None"
    ]
    assert {(line.get_marker(), *map(float, line.get_ydata())) for line in black} == {("o", 14.6)}


def test_plots_compute_nothing():
    """The package imports nothing of scalar but the writer of files and the constants of units."""
    allowed = {"scalar.data.io.atomic", "scalar.units"}
    for path in Path(study.plots.__file__).parent.glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            assert {name for name in names if name.split(".")[0] == "scalar"} <= allowed, path.name


def test_an_unknown_suffix_leaves_nothing_behind(tmp_path):
    """A figure with an unknown suffix is refused, and leaves no file."""
    with pytest.raises(KeyError):
        save_figure(Figure(), [tmp_path / "figure.gif"])
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.0886525, "0.0887"), (103.9, "104"), (0, "0"), (3.2e-7, "3.20e-07"), (26.26, "26.3")],
)
def test_numerals_are_short_and_readable(value, text):
    """A numeral has three digits, and an exponent only if one is needed."""
    assert numeral(value) == text


def test_units_come_from_the_columns_name():
    """The unit, mm or °, is that at the end of the column's name."""
    assert with_unit(14.6, "position_mean_mm") == "14.6 mm"
    assert with_unit(4.05, "orientation_mean_deg") == "4.05°"
