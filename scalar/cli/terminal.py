"""What a person reads on the terminal: short, in millimetres and degrees, with how sure it is and what could not be seen."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np

from scalar.effects.transfer import describe as describe_carried
from scalar.estimation.result import Calibration
from scalar.units import DEG, MM

if TYPE_CHECKING:
    from scalar.data.dataset import Dataset
    from scalar.diagnosis.diagnose import Diagnosis
    from scalar.evaluate import Evaluation

_MISFIT_WORTH_SAYING = 1.15
_SILENT_SHOWN = 4
_EFFECTS_NAMED = 8
_COEFFICIENTS_SHOWN = 3
_PLAIN = str.maketrans(
    {"−": "-", "±": "+-", "°": "deg", "²": "2", "×": "x"}
)  # for terminals that know no more


@contextmanager
def progress(label: str) -> Iterator[Callable[[str, int, int], None]]:
    """Show a progress bar on stderr while the block runs, where stderr is a terminal; yields ``advance(stage, done, total)``."""
    if not sys.stderr.isatty():
        yield lambda stage, done, total: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(label, total=None)
        yield lambda stage, done, total: bar.update(task, description=stage, completed=done, total=total)


@contextmanager
def stages() -> Iterator[Callable[[str], None]]:
    """Show which stage runs on stderr, where stderr is a terminal; yields a function that takes the stage's name."""
    if not sys.stderr.isatty():
        yield lambda stage: None
        return
    from rich.console import Console

    with Console(stderr=True).status("reading") as status:
        yield lambda stage: status.update(stage)


def describe_dataset(dataset: Dataset) -> str:
    """Return what a dataset holds, a few lines."""
    lines = [
        f"{dataset.name}: robot {dataset.robot.name}, {dataset.robot.n_joints} joints; sensor {dataset.sensor.kind}",
    ]
    if dataset.sensor.kind == "tracker":
        lines.append(f"  {dataset.n_poses} poses tracked")
    else:
        counts = np.bincount(dataset.plane_index, minlength=len(dataset.planes))
        per_plane = ", ".join(
            f"{plane.name} {count}" for plane, count in zip(dataset.planes, counts, strict=True)
        )
        lines.append(f"  {dataset.n_poses} poses: {per_plane}")
    if dataset.sensor.kind == "line-laser":
        points = np.diff(dataset.starts)
        lines.append(f"  {len(dataset.points)} points, {points.min()} to {points.max()} a scan")
    noise = dataset.sensor.noise
    lines.append(f"  noise {'not stated' if noise is None else f'{noise / MM:g} mm'}; no fault found")
    return "\n".join(lines)


def describe_calibration(calibration: Calibration) -> str:
    """Return what was found, how sure it is, and what could not be seen."""
    summary = calibration.summary
    model = calibration.model
    lines = [
        f"{model.robot.name}: {summary['poses']} poses, {summary['points']} points; "
        f"residual {calibration.residual_rms / MM:.4g} mm RMS",
    ]
    misfit, p_value = summary.get("misfit"), summary.get("misfit_p_value")
    if misfit is not None and p_value is not None:
        if misfit > _MISFIT_WORTH_SAYING and p_value < 1e-3:
            lines.append(
                f"  the residual is {misfit:.1f} times what the noise explains: the model lacks something; "
                "try 'scalar diagnose'"
            )
        else:
            lines.append(f"  the residual is what the noise explains (ratio {misfit:.2f})")
    std = calibration.std
    lines.append("  parameter        nominal    calibrated        change     std")
    for kind in ("a", "alpha", "d", "theta"):
        for i in range(model.robot.n_joints):
            name = f"{kind}_{i + 1}"
            if name not in std:
                continue
            unit, text = (MM, "mm ") if kind in ("a", "d") else (DEG, "deg")
            nominal = model.nominal.geometry[("a", "alpha", "d", "theta").index(kind), i] / unit
            value = model.robot.geometry[("a", "alpha", "d", "theta").index(kind), i] / unit
            lines.append(
                f"    {name:<9} {nominal:12.4f}  {value:12.4f}  {value - nominal:12.4f}  {std[name] / unit:8.4f} {text}"
            )
    t, r = model.sensor[:3] / MM, model.sensor[3:] / DEG
    lines.append(
        f"  sensor on flange: [{t[0]:.3f} {t[1]:.3f} {t[2]:.3f}] mm, rotation vector [{r[0]:.4f} {r[1]:.4f} {r[2]:.4f}] deg"
    )
    for plane in calibration.to_mapping()["planes"]:
        n = plane["normal"]
        lines.append(
            f"  plane {plane['name']}: normal [{n[0]:.5f} {n[1]:.5f} {n[2]:.5f}], distance {plane['distance'] / MM:.3f} mm"
            + (f" +- {plane['distance_std_m'] / MM:.3f}" if plane["distance_std_m"] else "")
        )
    for effect in model.effects:
        for name, unit, value in zip(
            effect.parameter_names, effect.coefficient_units, effect.coefficients, strict=True
        ):
            spread = f" +- {std[name]:.2g}" if name in std else " (held)"
            lines.append(f"  effect {name}: {value:.4g}{spread} {unit}")
    lines += describe_carried(summary.get("effects_from"))
    near = summary.get("kept_near_data_sheet") or {}
    if near:
        lines.append(f"  kept near the data sheet, because these poses hardly see it: {', '.join(near)}")
    if calibration.gauge:
        lines.append(f"  held, because the data cannot see it ({len(calibration.gauge)}):")
        lines += [f"    {entry['held']}: {entry['reason']}" for entry in calibration.gauge]
    return "\n".join(lines)


def describe_diagnosis(diagnosis: Diagnosis) -> str:
    """Return what was found, in about ten lines."""
    from scalar.report import words

    d = diagnosis.to_mapping()
    before, after = d["residual"]["before"], d["residual"]["after"]
    verdict = {
        "no_effect": "nothing but noise: these data show nothing that the model lacks",
        "effect": "found what the model lacks",
        "unattributed": "the residual holds structure that no known effect explains",
    }[d["verdict"]]
    lines = [f"{diagnosis.dataset.name}: {verdict}"]
    for entry in d["effects"][:_EFFECTS_NAMED]:
        title = words.title(entry["name"], entry["target"], entry.get("depends_on", ()))
        lines.append(f"  {title}{_sizes(entry)}")
        if entry["confounded_with"]:
            near = [words.title(c["name"], c["target"]) for c in entry["confounded_with"]]
            more = [f"{len(near) - 3} more"] if len(near) > 3 else []
            lines.append(f"    these data do not tell it from {words.listed(near[:3] + more, 'or')}")
    if len(d["effects"]) > _EFFECTS_NAMED:
        lines.append(f"  and {len(d['effects']) - _EFFECTS_NAMED} more")
    lines.append(
        f"  error on held-out poses {before['held_out_rms_mm']:.4f} -> {after['held_out_rms_mm']:.4f} mm RMS; "
        f"noise alone would leave {d['residual']['floor_mm']:.4f} mm"
    )
    outliers = d["outliers"]
    if outliers["poses"] or outliers["points"]:
        lines.append(
            f"  set aside: {len(outliers['poses'])} poses, {len(outliers['mislabelled'])} of them on another plane "
            f"than said, and {outliers['points']} points"
        )
    if d["silent"]:
        hidden = list(dict.fromkeys(words.title(s["name"], s["target"]) for s in d["silent"]))
        more = len(hidden) - _SILENT_SHOWN
        shown = hidden[:_SILENT_SHOWN] + ([f"{more} more (see the report)"] if more > 0 else [])
        lines.append(f"  cannot be seen here: {words.listed(shown)}")
    return "\n".join(lines).translate(_PLAIN)


def _sizes(entry: Mapping[str, Any]) -> str:
    """Return the coefficients of an effect for a line: all of few, or the most certain one of many."""
    from scalar.report import words

    shown = list(entry["coefficients"].items())
    if len(shown) > _COEFFICIENTS_SHOWN:
        shown = sorted(shown, key=lambda c: -abs(c[1]["value"]) / (c[1]["std"] or np.inf))[:1]
    rows = [words.coefficient(name, c["value"], c["std"]) for name, c in shown]
    texts = [f"{name} {value} ± {std} {unit}" for name, value, std, unit in rows]
    rest = len(entry["coefficients"]) - len(shown)
    return (": " + ", ".join(texts) if texts else "") + (f", and {rest} more coefficients" if rest else "")


def describe_evaluation(evaluation: Evaluation) -> str:
    """Return the errors against the truth, raw and aligned."""
    lines = [
        f"errors over {len(evaluation.raw.position)} poses   position mean / max [mm]   orientation mean / max [deg]"
    ]
    for name, errors in (("raw", evaluation.raw), ("aligned", evaluation.aligned)):
        e = errors.to_mapping()
        lines.append(
            f"  {name:<8} {e['position_mean_mm']:18.4f} / {e['position_max_mm']:.4f}"
            f" {e['orientation_mean_deg']:18.5f} / {e['orientation_max_deg']:.5f}"
        )
    if not evaluation.planes.empty:
        worst = evaluation.planes.loc[evaluation.planes["normal_error_deg"].idxmax()]
        largest = evaluation.planes["distance_error_mm"].abs().max()
        lines.append(
            f"  planes (raw): distance within {largest:.4f} mm, "
            f"normal within {worst['normal_error_deg']:.5f} deg"
        )
    return "\n".join(lines)
