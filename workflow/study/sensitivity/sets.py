"""The blind sets of the study: a config, checked, and a row for each set.

The first sets are the screening: every setting is varied on them. On the others only settings are varied that changed an answer there, or
whose change could alter the course of the diagnosis in no set of the screening.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from scalar.data.io.plain_yaml import load_yaml
from scalar.errors import Fault, InvalidInput
from study.common.schema_faults import refuse_by_schema

SCHEMA = Path(__file__).parent / "schemas/sensitivity.schema.json"


@dataclass(frozen=True)
class BlindSet:
    """One dataset to make.

    Attributes:
        name: Fit for a path.
        workcell: A key of ``Sets.workcells``.
        seed: Of all random draws in it.
        sensor: ``line_laser``, ``tracker`` or ``probe``.
        injected: Entries of the scene's ``injected``; targets that are not given are drawn from the seed.
        gross_errors: Shares of stray points, corrupted poses and wrong labels.
        overrides: ``{dotted key: value}`` of the scene.
    """

    name: str
    workcell: str
    seed: int
    sensor: str = "line_laser"
    injected: tuple[Mapping[str, Any], ...] = ()
    gross_errors: Mapping[str, float] = field(default_factory=dict)
    overrides: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Sets:
    """All sets of a config.

    Attributes:
        scene: ``{dotted key: value}`` of every scene.
        workcells: ``{name: {"scene": file, "overrides": {dotted key: value}}}``.
        screening: How many of the sets, from the first on, every setting is varied on.
        sets: By name, in the order of the config.
    """

    scene: Mapping[str, Any]
    workcells: Mapping[str, Mapping[str, Any]]
    screening: int
    sets: Mapping[str, BlindSet]

    @property
    def screened(self) -> list[str]:
        """Return the names of the sets on which every setting is varied."""
        return list(self.sets)[: self.screening]

    @property
    def others(self) -> list[str]:
        """Return the names of the other sets."""
        return list(self.sets)[self.screening :]


def load_sets(path: str | Path) -> Sets:
    """Return the sets that a YAML file lists.

    Raises:
        InvalidInput: With every fault found; a misspelt key is named.
    """
    content, file = load_yaml(Path(path)), Path(path).name
    refuse_by_schema(content, SCHEMA, file)
    faults: list[Fault] = []
    names = [entry["name"] for entry in content["sets"]]
    for i, entry in enumerate(content["sets"]):
        if entry["workcell"] not in content["workcells"]:
            known = ", ".join(content["workcells"])
            message = f"no workcell {entry['workcell']!r}; there are {known}"
            faults.append(Fault(file, message, column=f"sets.{i}.workcell"))
        if names.index(entry["name"]) != i:
            faults.append(
                Fault(file, f"a set before has the name {entry['name']!r}", column=f"sets.{i}.name")
            )
    if faults:
        raise InvalidInput(faults)
    sets = {
        entry["name"]: BlindSet(**{**entry, "injected": tuple(entry.get("injected", ()))})
        for entry in content["sets"]
    }
    workcells = {name: {"overrides": {}, **workcell} for name, workcell in content["workcells"].items()}
    return Sets(content["scene"], workcells, content["screening"], sets)
