"""Pictures: what lies beyond the axes stays in sight, what is thinned is told, and any number of poses fits
into a page."""

from __future__ import annotations

import re
import subprocess
import sys
from dataclasses import replace
from types import SimpleNamespace
from xml.etree import ElementTree

import matplotlib
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scalar.effects import pose_lag
from scalar.effects.picture import Axis, Map, Profile
from scalar.effects.pose_lag import PASSING, PoseLag
from scalar.report.axes import dot_titles, range_of
from scalar.report.panel import Panel
from scalar.report.pictures import draw
from scalar.report.thinning import dots_per_panel, thinned

HOSTILE = "\"><img src=//x onerror='alert(1)'>&"


def profile(count: int, seed: int = 0) -> Profile:
    """Return what ``count`` poses ask of an error of a joint that is a sine of its angle."""
    rng = np.random.default_rng(seed)
    x, std = rng.uniform(-2.9, 2.9, count), np.full(count, 1e-4)
    rest, fitted = rng.normal(0.0, 1e-4, count), 5e-4 * np.sin(x)
    grid = np.linspace(-2.9, 2.9, 181)
    curve = np.stack([grid, 5e-4 * np.sin(grid), np.full(181, 1e-5)])
    axes = Axis("angle of joint 2", "rad"), Axis("error of joint 2", "rad")
    return Profile(*axes, x, fitted + rest, rest, std, fitted, curve)


def panel(**more: str) -> Panel:
    """Return an empty panel over the unit square."""
    words = {"title": "all poses", "x_label": "order", "y_label": "residual [mm]"} | more
    return Panel((0.0, 1.0), (0.0, 1.0), **words)


def dots(markup: str) -> list[ElementTree.Element]:
    """Return the marks of a picture that say something."""
    return [e for e in ElementTree.fromstring(markup).iter("use") if e.find("title") is not None]


@pytest.mark.parametrize(("slides", "shown"), [(False, "[°/s]"), (True, "[mm/s]")])
def test_an_error_with_a_velocity_is_drawn(slides: bool, shown: str) -> None:
    """The picture of a joint that was logged late, measured in passing, has its velocity in degrees or millimetres a second."""
    found: list[Axis] = []

    def profile_over(view: object, effect: object, joint: int, axis: Axis, values: object) -> Profile:
        found.append(axis)
        return replace(profile(20), x_axis=axis)

    lag = PoseLag(2, slides, (PASSING,))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(pose_lag, "joint_profile", profile_over)
        patch.setattr(PoseLag, "_column", lambda *_: np.zeros(20))
        (picture,) = lag.pictures(SimpleNamespace(nominal=None, poses=None))  # type: ignore[arg-type]
    markup = draw(picture, np.arange(20), 100)
    assert found and shown in str(markup)


def test_what_lies_beyond_the_axes_stands_at_their_edge() -> None:
    """Every finite value has a mark with its own title inside the axes; those beyond are counted; what is not
    finite is left out."""
    drawn = panel()
    x, y = np.array([0.5, 2.0, 0.25, np.nan, 0.75]), np.array([0.5, 0.5, -3.0, 0.5, np.inf])
    assert drawn.marks(x, y, ["in", "right", "below", "none", "none"], "dot") == 2
    found = {
        e.findtext("title"): (float(e.attrib["x"]), float(e.attrib["y"])) for e in dots(drawn.markup("alt"))
    }
    assert set(found) == {"in", "right", "below"}
    assert found["right"][0] > found["in"][0] and found["right"][1] == found["in"][1]
    assert found["below"][1] > found["in"][1]
    assert all(0.0 <= u <= 400.0 and 0.0 <= v <= 284.0 for u, v in found.values())


@pytest.mark.slow
@given(st.lists(st.tuples(st.floats(0, 1), st.floats(0, 1)), min_size=1, max_size=20))
def test_dots_keep_their_order_and_place(points: list[tuple[float, float]]) -> None:
    """Each dot has the title of its own value, and stands where the axes put that value."""
    x, y = np.array(points).T
    drawn = panel()
    drawn.marks(x, y, [str(i) for i in range(len(x))], "dot")
    marks = dots(drawn.markup("alt"))
    assert [e.findtext("title") for e in marks] == [str(i) for i in range(len(x))]
    for values, name in ((x, "x"), (y, "y")):
        at = np.array([float(e.attrib[name]) for e in marks])
        slope = 342.0 if name == "x" else -204.0  # the axes in points, between the margins
        np.testing.assert_allclose(at - at[0], slope * (values - values[0]), atol=0.11)


def test_words_cannot_open_a_tag_nor_stop_the_report() -> None:
    """Labels are shown as they are: markup, formulas that are none, letters that no font here has, and
    characters that XML forbids do no harm."""
    for text in (HOSTILE, "$\\frac{", "温度", "bell\x07"):
        root = ElementTree.fromstring(panel(x_label=text, title=text, y_label="<b>").markup(text))
        assert not {e.tag for e in root.iter()} & {"img", "script", "b"}
        assert text.replace("\x07", " ") in [e.text for e in root.iter("text")]
        assert root.get("aria-label") == text.replace("\x07", " ")


def test_a_picture_does_not_depend_on_the_settings_of_the_user() -> None:
    """The same values give the same bytes, whatever Matplotlib is set to."""
    plain = draw(profile(40), np.arange(40), 1000)
    with matplotlib.rc_context({"font.size": 30.0, "axes.facecolor": "red", "svg.fonttype": "path"}):
        assert draw(profile(40), np.arange(40), 1000) == plain


def test_dots_say_pose_place_and_value_in_the_units_of_the_axes() -> None:
    """Degrees stand without a space, millimetres with one, the order of acquisition by its name."""
    angle, length, order = Axis("angle", "rad"), Axis("height", "m"), Axis("order of acquisition", "")
    values = np.array([-1.5])
    assert dot_titles(np.array([7]), [(angle, np.array([30.0]))], length, values) == [
        "pose 7 at 30.0°: −1.50 mm"
    ]
    assert dot_titles(np.array([7]), [(order, np.array([12.0]))], angle, values) == [
        "pose 7 at order 12: −1.50°"
    ]


@pytest.mark.parametrize("poses", [3_000, 12_000])
@pytest.mark.parametrize("pictures", [2, 13, 40])
def test_any_number_of_poses_fits_into_a_page(poses: int, pictures: int) -> None:
    """However many poses and pictures, all pictures of a page take less than 2.8 MB together, which leaves
    0.2 MB of the 3 for the rest."""
    pair = draw(profile(poses), np.arange(poses) + 100_000, dots_per_panel(2 * pictures))
    assert pair.after is not None
    assert pictures * (len(pair.before.encode()) + len(pair.after.encode())) < 2.8e6


def test_all_poses_of_an_ordinary_page_are_drawn() -> None:
    """With 3,000 poses and two effects nothing is thinned: three pictures show every pose twice."""
    pair = draw(profile(3_000), np.arange(3_000), dots_per_panel(6))
    assert len(dots(pair.before)) == 3_000
    assert "are drawn" not in pair.caption


def test_thinning_keeps_the_outliers_and_is_told() -> None:
    """Of too many values those that lie farthest out are drawn, in both pictures, and the caption says how
    many of how many."""
    many = profile(5_000)
    many.rest[[17, 4_321]] = 0.01
    many.y[[17, 4_321]] = many.fitted[[17, 4_321]] + 0.01
    pair = draw(many, np.arange(5_000), 400)
    assert pair.after is not None
    for picture in (pair.before, pair.after):
        assert len(dots(picture)) == 400
        assert re.search(r"<title>pose 17 at", picture) and re.search(r"<title>pose 4321 at", picture)
    assert "400 of 5000 values are drawn" in pair.caption
    assert "beyond the axes" in pair.caption


@given(st.integers(1, 500), st.integers(10, 600))
def test_thinning_draws_as_many_as_it_may(count: int, most: int) -> None:
    """Exactly as many are drawn as there is room for, the largest among them."""
    oddness = np.random.default_rng(count).normal(size=count)
    drawn = thinned(oddness, most)
    assert drawn.sum() == min(count, most)
    assert drawn[np.argmax(np.abs(oddness))]


def test_marks_of_a_map_grow_with_their_value() -> None:
    """On a map a larger value has a larger mark; marks below and above zero differ in colour."""
    axes = Axis("x of the base", "m"), Axis("y of the base", "m"), Axis("height over the plane", "m")
    y = np.array([1e-4, 4e-4, -4e-4])
    pair = draw(
        Map(*axes, np.arange(3.0), np.arange(3.0), y, y / 10, np.array([4, 5, 6])), np.arange(10, 20), 100
    )
    root = ElementTree.fromstring(pair.before)
    extent, colour = {}, {}
    for group in root.iter("g"):
        if group.get("class") == "dots":
            shapes = {e.attrib["id"]: e.attrib["d"] for e in group.iter("path")}
            for mark in group.iter("use"):
                numbers = [float(v) for v in re.findall(r"-?[\d.]+", shapes[mark.attrib["href"][1:]])]
                pose = int(str(mark.findtext("title")).split()[1])
                extent[pose], colour[pose] = max(map(abs, numbers)), group.attrib["style"].split(";")[0]
    assert set(extent) == {14, 15, 16}
    assert extent[14] < extent[15] == extent[16]
    assert colour[14] == colour[15] != colour[16]


@given(st.lists(st.floats(-1e3, 1e3), min_size=1, max_size=30))
def test_range_holds_what_it_is_of(values: list[float]) -> None:
    """A range of all values holds each of them strictly, even where all are the same."""
    low, high = range_of([np.array(values)])
    assert low < min(values) and max(values) < high


def test_plotting_is_imported_only_to_draw() -> None:
    """Neither the command line nor the report's words load what draws: it loads when a report is drawn."""
    code = "import sys, scalar.cli, scalar.report.words; sys.exit('matplotlib.figure' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
