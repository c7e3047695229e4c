"""Every figure can be read: no text below 6 pt where the paper shows it, none that stands on other text or reaches over the edge, no data cut off.

The width at which the paper shows a figure is read from its text; an index or an exponent counts with the text that it belongs to.
Drawn of the committed summaries where there are some, else of tables as full as those of a whole run.
"""

import re
import tempfile
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from matplotlib.figure import Figure
from matplotlib.image import imsave
from study.common.methods import BOUND, METHODS
from study.common.tables import read_table
from study.headline.summary import QUANTITIES
from study.plots import blind_trials, measured
from study.plots.confidence import draw_confidence
from study.plots.correlation import draw_correlation
from study.plots.published_curves import draw_curves, draw_recovery, draw_support
from study.plots.scene import draw_scene
from study.plots.sensitivity import draw_sensitivity
from study.plots.sequential import draw_sequential
from study.plots.style import COLUMN_IN, PAGE_IN, new_figure, save_figure, styled
from study.plots.sweep import draw_sweep
from study.plots.sweep_overview import draw_overview
from study.plots.worked_example import draw_worked_example
from study.plots.workspace import draw_workspace
from study.sequential.summary import summarise_sequential
from study.sweeps.summary import summarise_sweep

from tests.study.plots import readable, test_draw_scene_figures, test_draw_sequential, test_plots
from tests.typst_text import picture_widths

ROOT = Path(__file__).parents[3]
CURVES = read_table(ROOT / "workflow/resources/published_curves.csv")
AXES = {
    "noise": {"label": "noise of a point [mm]", "published": "noise"},
    "plane_offset": {"label": "offset of the initial planes [mm]", "published": "plane_offset"},
    "plane_tilt": {"label": "tilt of the initial planes [°]", "scale": "linear", "published": "plane_tilt"},
    "poses": {"label": "poses on three planes", "published": "poses"},
}


def summary(study: str, name: str) -> pd.DataFrame:
    """Return a table of the committed summaries."""
    return read_table(ROOT / "paper/summaries" / study / f"{name}.csv")


def sweep(name: str) -> pd.DataFrame:
    """Return summary.csv of a sweep over its published values, thirty seeds, some fits failed."""
    rng = np.random.default_rng(4)
    rows = []
    for value in CURVES.loc[CURVES["sweep"] == name, "value"]:
        for seed in range(30):
            for method in (*METHODS, BOUND):
                status = "raised" if method == "baseline-raise" and seed % 3 else "converged"
                key = {
                    "walls": "upright",
                    "case": f"at-{value:g}",
                    "value": value,
                    "seed": seed,
                    "method": method,
                }
                key |= {"status": BOUND if method == BOUND else status, "alignment": "raw"}
                rows.append(key | dict(zip(QUANTITIES, 10.0 ** rng.uniform(-2, 1, 4), strict=True)))
    return summarise_sweep(pd.DataFrame(rows))


def correlations() -> pd.DataFrame:
    """Return a correlation matrix of the parameters of a six-axis arm, its scanner and three planes, strong pairs beside one another."""
    names = [f"{kind}_{i}" for kind in ("a", "d") for i in range(2, 7)]
    names += [f"{kind}_{i}" for kind in ("alpha", "theta") for i in range(2, 7)]
    names += [f"sensor_{axis}" for axis in ("x", "y", "z", "rx", "ry", "rz")]
    names += [
        name
        for plane in ("floor", "wall_x", "wall_y")
        for name in (f"normal_{plane}_u", f"normal_{plane}_v", f"distance_{plane}")
    ]
    matrix = np.eye(len(names)) - 0.93 * (np.eye(len(names), k=1) + np.eye(len(names), k=-1))
    return pd.DataFrame({"parameter": names}).join(pd.DataFrame(matrix, columns=names))


def candidates() -> pd.DataFrame:
    """Return candidates.csv: explanations of the published curves, the second with two magnitudes."""
    labels = {
        "stated": "stated noise alone",
        "scan": "error of each scan",
        "jitter": "jitter of the joints",
        "early_stop": "solver stops early",
        "bow": "target planes that are not flat",
    }
    rows = []
    for k, (name, label) in enumerate(labels.items()):
        row = {
            "candidate": name,
            "label": label,
            "behind": 60.0 * k**2,
            "misfit_factor": 1.0 + k,
            "misfit_factor_with_offset": 1.1,
        }
        row |= {
            "verdict": ("supported", "disfavoured", "excluded")[min(k, 2)],
            "behind_flat": 50.0 * k**2,
            "behind_wide": 70.0 * k**2,
        }
        for m in (1, 2) if k == 1 else (1,):
            row |= {
                f"magnitude_{m}": "spread",
                f"unit_{m}": "mm",
                f"value_{m}": 0.12,
                f"low_{m}": 0.1,
                f"high_{m}": 0.14,
            }
        rows.append(row)
    return pd.DataFrame(rows)


def predictions() -> pd.DataFrame:
    """Return predictions.csv of all published points."""
    rng = np.random.default_rng(6)
    rows = []
    for point in CURVES.to_dict("records"):
        for name in candidates()["candidate"]:
            for quantity in QUANTITIES:
                middle = point[quantity] * rng.uniform(0.5, 2.0)
                row = {
                    "sweep": point["sweep"],
                    "value": point["value"],
                    "candidate": name,
                    "quantity": quantity,
                }
                row |= {"published": point[quantity], "median": middle, "without_offset": middle}
                rows.append(row | {"p05": middle / 2, "p95": middle * 2})
    return pd.DataFrame(rows)


def recovery() -> pd.DataFrame:
    """Return recovery.csv of the candidates."""
    names = list(candidates()["candidate"])
    return pd.DataFrame(
        [
            {"injected": a, "tried": b, "indistinguishable": 0.95 if a == b else 0.1}
            for a in names
            for b in names
        ]
    )


def worked_example() -> Figure:
    """Return the figure of an example with an effect of joint 4."""
    rng = np.random.default_rng(8)
    angle = rng.uniform(-170, 170, 150)
    poses = pd.DataFrame({"angle_deg": angle, "plane": np.resize(["floor", "wall_x", "wall_y"], 150)})
    poses["residual_before_mm"] = 0.4 * np.sin(2 * np.deg2rad(angle)) + 0.03 * rng.standard_normal(150)
    poses["residual_after_mm"] = 0.03 * rng.standard_normal(150)
    poses["asked_deg"], poses["asked_std_deg"] = 0.05 * np.sin(2 * np.deg2rad(angle)), 0.01
    x = np.linspace(-180, 180, 181)
    curve = pd.DataFrame({"angle_deg": x, "effect_deg": 0.05 * np.sin(2 * np.deg2rad(x))})
    names = [f"joint_harmonic, joint {k}, order 2" for k in range(1, 7)] + [
        "base_compliance",
        "thermal_drift",
    ]
    ranking = pd.DataFrame(
        {"candidate": names, "evidence_nats": 900.0 / np.arange(1, 9), "share_of_residual": 0.9}
    )
    ranking["found"] = ranking.index == 0
    errors = pd.DataFrame({"when": ["before", "after", "control"], "position_mean_mm": [0.5, 0.021, 0.02]})
    held_out = {"before": 0.3, "after": 0.031, "noise": 0.03}
    numbers = {"found": {"joint": 4}, "held_out_rms_mm": held_out, "errors_over": 10_000}
    return draw_worked_example(poses, curve, ranking, errors, numbers)


def sequential() -> Figure:
    """Return the figure of orders, two cases."""
    table = test_draw_sequential.table(5)
    return draw_sequential(table, summarise_sequential(table))


def scene() -> Figure:
    """Return the picture of a workcell with its parts named."""
    picture = np.full((300, 400, 3), 255, dtype=np.uint8)
    picture[20:280, 20:380] = 90
    places = {
        "floor": (150.0, 250.0),
        "wall_x": (300.0, 60.0),
        "scanner": (250.0, 120.0),
        "base": (100.0, 180.0),
    }
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "picture.png"
        imsave(path, picture)
        return draw_scene(path, places)


DRAWN = {
    "headline": test_plots.figures,
    "scene": lambda: {"": scene()},
    "correlation": lambda: {"": draw_correlation(correlations())},
    "workspace": lambda: {"": draw_workspace(test_draw_scene_figures.errors(), 5)},
    "sequential": lambda: {"": sequential()},
    "sweep, log": lambda: {
        "": draw_sweep(sweep("noise"), CURVES[CURVES["sweep"] == "noise"], "noise of a point [mm]")
    },
    "sweep, linear": lambda: {
        "": draw_sweep(sweep("plane_tilt"), CURVES[CURVES["sweep"] == "plane_tilt"], "tilt [°]", "linear")
    },
    "sweeps": lambda: {"": draw_overview({name: sweep(name) for name in AXES}, CURVES, AXES)},
    "published curves": lambda: {
        "curves": draw_curves(candidates(), predictions()),
        "support": draw_support(candidates()),
        "recovery": draw_recovery(candidates(), recovery()),
    },
    "worked example": lambda: {"": worked_example()},
    "blind trials": lambda: {
        "confusion": blind_trials.draw_confusion(summary("blind_trials", "confusion")),
        "power": blind_trials.draw_power(
            summary("blind_trials", "power"), summary("blind_trials", "thresholds")
        ),
        "errors": blind_trials.draw_errors_after(summary("blind_trials", "errors")),
        "reliability": blind_trials.draw_reliability(summary("blind_trials", "reliability")),
    },
    "confidence": lambda: {"": draw_confidence(summary("confidence", "reliability"))},
    "sensitivity": lambda: {"": draw_sensitivity(summary("sensitivity", "settings"))},
    "measured": lambda: {
        "errors": measured.draw_errors(summary("measured", "errors")),
        "gears": measured.draw_gears(summary("measured", "gears")),
    },
}


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
    """Over the page, over a share of it, and in a column."""
    text = '#picture("a.svg", [x])\n#picture("b.svg", width: 50%, [x])\n#picture(\n  "c.svg", in-column: true,\n  [x])'
    assert picture_widths(text, 8.0, 3.0) == {"a.svg": 8.0, "b.svg": 4.0, "c.svg": 3.0}


def test_a_file_is_as_wide_as_its_figure(tmp_path):
    """Sizes of type are scaled from the width of the figure: the file that the paper shows has the same."""
    figure = flawed("")
    save_figure(figure, [tmp_path / "figure.svg"])
    written = re.search(
        r'<svg[^>]* width="([\d.]+)pt"', (tmp_path / "figure.svg").read_text(encoding="utf-8")
    )
    assert written is not None
    assert float(written[1]) / 72.0 == pytest.approx(figure.get_size_inches()[0], rel=1e-3)


@pytest.mark.parametrize("name", DRAWN)
def test_a_figure_can_be_read(name):
    """Every text and every value is there to be seen."""
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
    """A figure without the flaw passes, with it exactly one check fails: these checks can fail."""
    readable.assert_readable(flawed(""))
    checks = ("small_texts", "overlapping_texts", "texts_outside", "data_outside")
    assert [name for name in checks if getattr(readable, name)(flawed(flaw))] == [finds]


def test_a_figure_of_the_summaries_shows_every_row():
    """Of the blind trials: as many rows as cases, their number of sets written behind each; of the measured sets: a bar a number."""
    table = summary("blind_trials", "confusion")
    table = table[table["size"] >= 1.0]
    text = readable.words(blind_trials.draw_confusion(table))
    for case, rows in table.groupby("case"):
        assert f"{blind_trials.words(str(case))}  ({rows['count'].sum()})" in text
    errors = summary("measured", "errors")
    (ax,) = measured.draw_errors(errors).axes
    known = errors["model"].str.startswith(tuple(model for model, *_ in measured.MODELS))
    assert sorted(bar.get_height() for bar in ax.patches) == sorted(errors.loc[known, "held_out_rms_mm"])
