"""Every figure of the study, drawn of the committed summaries where there are some, else of tables as full as those of a whole run."""

import tempfile
from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.image import imsave
from study.common.methods import BOUND, METHODS
from study.common.tables import read_table
from study.headline.summary import QUANTITIES
from study.plots import blind_trials, measured
from study.plots.confidence import draw_confidence
from study.plots.correlation import draw_correlation
from study.plots.edges import draw_edges
from study.plots.published_curves import draw_curves, draw_recovery, draw_support
from study.plots.scene import draw_scene
from study.plots.sensitivity import draw_sensitivity
from study.plots.sequential import draw_sequential
from study.plots.sweep import draw_sweep
from study.plots.sweep_overview import draw_overview
from study.plots.worked_example import draw_worked_example
from study.plots.workspace import draw_workspace
from study.sequential.summary import summarise_sequential
from study.sweeps.summary import summarise_sweep

from tests.study.plots import test_draw_scene_figures, test_draw_sequential, test_plots

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
    "edges": lambda: {"": draw_edges(summary("edges", "edges"), summary("edges", "summary"))},
    "measured": lambda: {
        "errors": measured.draw_errors(summary("measured", "errors")),
        "gears": measured.draw_gears(summary("measured", "gears")),
    },
}
