"""What the grids of the sweeps ask for: the value of each case on its sweep's axis, and how many poses a posture plan must hold."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from scalar.errors import Fault, InvalidInput
from study.common.grid import Case

Cases = Mapping[str, Case]
"""The cases of one sweep by name."""


def refuse_cases_off_the_axis(axes: Mapping[str, Mapping[str, Any]], cases: Mapping[str, Cases]) -> None:
    """Refuse a case that does not state its sweep's key, or that starts from a scene of its own.

    Args:
        axes: ``{sweep: {"grid": file, "key": dotted key of the scene}}``. cases: ``{sweep: its cases}``.

    Raises:
        InvalidInput: With every such case.
    """
    faults = [
        Fault(
            axis["grid"], f"case {case.name}: a sweep's grid states {axis['key']} in every row, and no scene"
        )
        for sweep, axis in axes.items()
        for case in cases[sweep].values()
        if axis["key"] not in case.overrides or case.scene
    ]
    if faults:
        raise InvalidInput(faults)


def values_on_axis(axis: Mapping[str, Any], cases: Cases) -> dict[str, float]:
    """Return ``{case: value on the axis}``, in the unit of the axis's label: the key's value times the axis's ``factor``, or 1."""
    factor = axis.get("factor", 1)
    return {name: case.overrides[axis["key"]] * factor for name, case in cases.items()}


def in_groups(cases: Cases, per_group: int) -> dict[str, list[str]]:
    """Return ``{group: names of its cases}``: cases that follow one another in their grid, named by the first and the last.

    A row added at a grid's end leaves the groups that are full as they are.
    """
    names = list(cases)
    groups = [names[k : k + per_group] for k in range(0, len(names), per_group)]
    return {own[0] if len(own) == 1 else f"{own[0]}_to_{own[-1]}": own for own in groups}


def most_poses(cases: Mapping[str, Cases]) -> int:
    """Return the most poses a plane that any case of any sweep asks for; 1 where none says."""
    asked = [case.overrides.get("poses_per_plane", 1) for sweep in cases.values() for case in sweep.values()]
    return max(asked, default=1)
