"""Draw time and peak memory over the number of poses and of points a scan, from the table that ``benchmarks.sizes`` measured."""

from __future__ import annotations

import platform
from pathlib import Path

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from study.plots.style import COLOURS, PAGE_IN, PROPOSED, decimal_ticks, new_figure, styled

from benchmarks.other_solvers import CERES, JAX, OURS, YARDSTICK
from benchmarks.sizes import AT_POINTS, AT_POSES, WHOLE, measure_sizes
from scalar.data.io.atomic import atomic_write

TABLE, PICTURE = (Path(__file__).with_name(f"measured.{suffix}") for suffix in ("csv", "png"))
LOOKS = {
    YARDSTICK: (COLOURS["published"], "s"),
    CERES["point"]: (COLOURS["baseline-abs"], "^"),
    CERES["pose"]: (COLOURS["baseline-clip"], "v"),
    CERES["compressed"]: (COLOURS["baseline-raise"], "D"),
    JAX["points"]: (COLOURS["baseline-abs-2018"], "<"),
    JAX["compressed"]: (COLOURS["arm first, linear"], ">"),
    OURS: (PROPOSED, "o"),
    WHOLE: (COLOURS["first explanation"], "P"),
}
"""``{way: (colour, marker)}``, in the order of the legend."""
RESOLUTION = 120  # dots an inch: a small file, because it is committed
AXES = (
    ("poses", "points", AT_POINTS, f"number of poses, {AT_POINTS} points a scan"),
    ("points", "poses", AT_POSES, f"points a scan, {AT_POSES} poses"),
)
QUANTITIES = (("ms", "processor time [ms]"), ("mib", "peak memory [MiB]"))


def processor() -> str:
    """Return the type of this machine's processor, and its number of cores."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor() or platform.machine()
    models = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return f"{models[0]}, {len(models)} cores" if models else platform.machine()


def draw(table: pd.DataFrame, path: Path) -> Figure:
    """Draw the table, and return the figure: time above memory, over the number of poses and over that of points.

    Args:
        table: Columns ``way``, ``poses``, ``points``, ``ms``, ``mib`` and ``machine``.
        path: The picture.
    """
    with styled():
        figure = new_figure(PAGE_IN, 5.6)
        panels = figure.subplots(2, 2, sharex="col", sharey="row")
        for row, (quantity, label) in zip(panels, QUANTITIES, strict=True):
            row[0].set_ylabel(label)
            for panel, (along, fixed, at, _) in zip(row, AXES, strict=True):
                _lines(panel, table[table[fixed] == at], along, quantity)
        for panel, (_, _, _, label) in zip(panels[1], AXES, strict=True):
            panel.set_xlabel(label)
        handles, labels = panels[0][0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper center", ncols=2)
        note = "one thread; each value from a process of its own, imports included"
        figure.supxlabel(f"{table['machine'].iloc[0]}; {note}", fontsize="small")
        with atomic_write(path) as temporary:
            figure.savefig(temporary, format="png", dpi=RESOLUTION, metadata={"Software": None})
    return figure


def _lines(panel: Axes, table: pd.DataFrame, along: str, quantity: str) -> None:
    for way, (colour, marker) in LOOKS.items():
        own = table[table["way"] == way].sort_values(along)
        panel.plot(
            own[along], own[quantity], color=colour, marker=marker, markersize=4, linewidth=1.2, label=way
        )
    panel.set_xscale("log")
    panel.set_yscale("log")
    decimal_ticks(panel.xaxis)
    decimal_ticks(panel.yaxis)


def figure() -> None:
    """Measure all sizes, write the table, and draw it."""
    table = measure_sizes().assign(machine=processor())
    table.round(3).to_csv(TABLE, index=False, lineterminator="\n")
    draw(table, PICTURE)
    print(f"written: {TABLE.name} and {PICTURE.name} of the folder benchmarks")
