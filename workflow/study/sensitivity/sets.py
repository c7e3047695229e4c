"""Read the blind sets of the sensitivity study from a config.

Every setting is varied on the first sets, the screening. On the other sets, only those settings are varied that changed an answer in the screening,
or for which no diagnosis of the screening could come out differently.
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
    """One dataset to simulate.

    Attributes:
        name: Name of the set, which is part of the names of files.
        workcell: A key of ``Sets.workcells``.
        seed: Seed of all random draws in the set.
        sensor: ``line_laser``, ``tracker`` or ``probe``.
        injected: Entries of the scene's key ``injected``; targets that are not given are drawn from the seed.
        gross_errors: Shares of stray points (``points``), corrupted poses (``poses``) and wrong labels (``labels``).
        overrides: ``{dotted key: value}``, keys of the scene that this set replaces.
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
        scene: ``{dotted key: value}``, keys that are replaced in every scene.
        workcells: ``{name: {"scene": config file, "overrides": {dotted key: value}}}``.
        screening: Number of sets, from the first on, on which every setting is varied.
        sets: ``{name: set}``, in the order of the config.
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
        InvalidInput: The file is at fault; every fault is listed.
    """
    content, file = load_yaml(Path(path)), Path(path).name
    refuse_by_schema(content, SCHEMA, file)
    faults: list[Fault] = []
    names = [entry["name"] for entry in content["sets"]]
    for i, entry in enumerate(content["sets"]):
        if entry["workcell"] not in content["workcells"]:
            known = ", ".join(content["workcells"])
            message = f"unknown workcell {entry['workcell']!r}; the config has {known}"
            faults.append(Fault(file, message, column=f"sets.{i}.workcell"))
        if names.index(entry["name"]) != i:
            faults.append(
                Fault(
                    file, f"{entry['name']!r} names an earlier set too; rename one", column=f"sets.{i}.name"
                )
            )
    if faults:
        raise InvalidInput(faults)
    sets = {
        entry["name"]: BlindSet(**{**entry, "injected": tuple(entry.get("injected", ()))})
        for entry in content["sets"]
    }
    workcells = {name: {"overrides": {}, **workcell} for name, workcell in content["workcells"].items()}
    return Sets(content["scene"], workcells, content["screening"], sets)
