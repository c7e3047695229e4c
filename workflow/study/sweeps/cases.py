"""Read from the grids of the sweeps the value of each case on its sweep's axis, and the number of postures that a plan must contain."""

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
        axes: ``{sweep: {"grid": file, "key": dotted key of the scene}}``.
        cases: ``{sweep: its cases}``.

    Raises:
        InvalidInput: There are such cases; each is listed.
    """
    faults = [
        Fault(
            axis["grid"],
            f"case {case.name}: state {axis['key']} and no scene, as in every row of a sweep's grid",
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
    """Return ``{group: names of its cases}`` for groups of successive cases; a group is named by its first and its last case.

    A row that is added at the end of a grid does not change the groups that are full.
    """
    names = list(cases)
    groups = [names[k : k + per_group] for k in range(0, len(names), per_group)]
    return {own[0] if len(own) == 1 else f"{own[0]}_to_{own[-1]}": own for own in groups}


def most_poses(cases: Mapping[str, Cases]) -> int:
    """Return the largest number of poses per plane that any case of any sweep states; 1 if none states it."""
    asked = [case.overrides.get("poses_per_plane", 1) for sweep in cases.values() for case in sweep.values()]
    return max(asked, default=1)
