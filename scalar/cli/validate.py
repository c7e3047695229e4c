"""``scalar validate``: check a dataset, and say what it contains."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from scalar.cli.group import cli
from scalar.cli.options import PATH
from scalar.cli.terminal import say
from scalar.units import MM

if TYPE_CHECKING:
    from scalar.data.folder import Content
    from scalar.data.located_table import Table
    from scalar.data.sensor_formats import MeasuredTable

_LIDAR_NOISE = 2e-3  # m: stated noise from which a note is written; line scanners have 1e-5 to 2e-4


@cli.command()
@click.argument("dataset", type=PATH)
def validate(dataset: Path) -> None:
    """Check a dataset.

    Prints what the dataset contains and what looks wrong in it, or one line for each fault.

    \b
    Example:
      scalar validate my-cell
    """
    from scalar.data.folder import read_folder

    say(describe_content(read_folder(dataset)))


def _joints(joints: Sequence[Mapping[str, Any]]) -> str:
    """Return how many joints there are, and which of them slide."""
    sliding = [i + 1 for i, joint in enumerate(joints) if joint.get("type") == "prismatic"]
    count = f"{len(joints)} joint{'s' if len(joints) != 1 else ''}"
    if not sliding:
        return count
    from scalar.effects.title import joints_in_words  # slow to import

    return f"{count} ({joints_in_words(sliding)} slide{'s' if len(sliding) == 1 else ''})"


def _measurements(points: Table, layout: MeasuredTable | None) -> list[str]:
    """Return lines on how often each target was measured, and on measured orientations."""
    lines: list[str] = []
    if layout is None:
        return lines
    if layout.item is not None and layout.item in points.columns:
        counts = Counter(points.columns[layout.item])
        lines.append(f"  {layout.item}s: {', '.join(f'{name} {count}' for name, count in counts.items())}")
    turned = [name for group in layout.together for name in group if name in points.columns]
    if turned:
        lines.append(f"  whole poses: {','.join(turned)} are measured too")
    return lines


def describe_content(content: Content) -> str:
    """Return a few lines on what a dataset contains."""
    from scalar.cli.validate_notes import WARNING, notes_on
    from scalar.sensors import kind_named

    mapping, poses, points = content.mapping, content.poses, content.points
    robot, sensor = mapping["robot"], mapping["sensor"]
    kind = kind_named(sensor["kind"])
    lines = [
        f"{mapping['name']}: robot {robot['name']}, {_joints(robot['joints'])}; sensor {kind.format.kind}",
    ]
    if mapping.get("source"):
        lines.append(f"  source: {mapping['source']}")
    if not kind.format.on_planes:
        lines.append(f"  {poses.n_rows} poses {kind.measured}")
    else:
        counts = Counter(poses.columns["plane"])
        per_plane = ", ".join(f"{plane['name']} {counts[plane['name']]}" for plane in mapping["planes"])
        lines.append(f"  {poses.n_rows} poses: {per_plane}")
    if kind.scans and points is not None:
        sizes = Counter(points.columns["pose"].tolist()).values()
        of_each = f"{min(sizes)} to {max(sizes)}" if min(sizes) < max(sizes) else f"{max(sizes)}"
        lines.append(f"  {points.n_rows} points, {of_each} a scan")
    if points is not None:
        lines += _measurements(points, kind.format.table)
    if content.references is not None:
        lines += _measurements(content.references, kind.format.references)
    noise = sensor.get("noise")
    notes = notes_on(content, kind.format.table)
    found = "no fault found" + (", but see the warnings" if any(WARNING in note for note in notes) else "")
    if points is not None and "noise" in points.columns:
        least, most = (
            f"{bound / MM:g}" for bound in (points.columns["noise"].min(), points.columns["noise"].max())
        )
        lines.append(f"  noise of each measurement stated, {least} to {most} mm; {found}")
    else:
        lines.append(f"  noise {'not stated' if noise is None else f'{noise / MM:g} mm'}; {found}")
    if noise is not None and noise >= _LIDAR_NOISE:
        lines.append(
            f"  note: a noise of {noise / MM:g} mm is that of a lidar, and ten times that of a line scanner or more; dataset.yaml states it in metres"
        )
    return "\n".join([*lines, *notes])
