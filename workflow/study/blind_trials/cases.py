"""What a closed loop runs: its config, checked, and for every case and cell the sets to make.

A case is one thing to try (an effect over its sizes, dirt without an effect, pairs of effects, an effect of no
known name); a cell is a robot with a scanner among plates; a set is one dataset of a case in a cell, with a seed
and a size of its own.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np

from scalar.data.io.plain_yaml import load_yaml
from scalar.errors import Fault, InvalidInput

SCHEMA = Path(__file__).parent / "schemas/closed_loop.schema.json"


@dataclass(frozen=True)
class Choice:
    """Something that may be planted.

    Attributes:
        entry: Of the scene's ``planted``, without a size.
        natural: Size as real arms have it, in the effect's unit.
        cells: Where it can be planted.
    """

    entry: Mapping[str, Any]
    natural: float
    cells: tuple[str, ...]


@dataclass(frozen=True)
class Case:
    """One thing to try.

    Attributes:
        name: Fit for a path: the effect's, or ``null-DIRT``, ``pairs``, ``unknown-KIND``.
        kind: ``single``, ``null``, ``pair`` or ``unknown``.
        choices: What may be planted.
        together: How many of them a set plants; drawn from its seed where there are more.
        sizes: Multiples of the natural size; a set each.
        first_seed, seeds: The seed of the first cell, and how many each cell has.
        dirt: Shares of stray points, torn poses and wrong labels.
        overrides: ``{dotted key: value}`` of the scene, for this case alone.
    """

    name: str
    kind: str
    choices: tuple[Choice, ...]
    together: int
    sizes: tuple[float, ...]
    first_seed: int
    seeds: int
    dirt: Mapping[str, float] = field(default_factory=dict)
    overrides: Mapping[str, Any] = field(default_factory=dict)

    def possible(self, cell: str) -> list[Choice]:
        """Return the choices that can be planted in a cell."""
        return [choice for choice in self.choices if cell in choice.cells]


@dataclass(frozen=True)
class Set:
    """One dataset to make and to diagnose.

    Attributes:
        case, kind, cell: As above, by name.
        seed: Of all chance in it.
        size: Multiple of the natural size.
        planted: Entries of the scene's ``planted``, sizes included.
        dirt, overrides: As above.
    """

    case: str
    kind: str
    cell: str
    seed: int
    size: float
    planted: tuple[Mapping[str, Any], ...]
    dirt: Mapping[str, float]
    overrides: Mapping[str, Any]


@dataclass(frozen=True)
class Study:
    """A whole closed loop.

    Attributes:
        scene: ``{dotted key: value}`` of every scene.
        cells: ``{name: {"scene": file, "overrides": {dotted key: value}}}``.
        cases: By name, in the order of the config.
        units: ``{case of a single effect: unit of its size}``.
        seeds_per_job: How many seeds one job takes; changes no result.
    """

    scene: Mapping[str, Any]
    cells: Mapping[str, Mapping[str, Any]]
    cases: Mapping[str, Case]
    units: Mapping[str, str]
    seeds_per_job: int

    def jobs(self) -> list[tuple[str, str, str]]:
        """Return (case, cell, repetitions) of every job; repetitions as ``repetitions_of`` reads them, ``001-002``."""
        return [
            (case.name, cell, f"{k + 1:03d}-{min(k + self.seeds_per_job, case.seeds):03d}")
            for case in self.cases.values()
            for cell in self.cells
            if len(case.possible(cell)) >= case.together
            for k in range(0, case.seeds, self.seeds_per_job)
        ]

    def sets(self, case: str, cell: str, repetitions: str) -> Iterator[Set]:
        """Yield the sets of one job, seed by seed.

        Seeds count on through the cells: each cell has its own, and more of them leave those that are there.
        """
        wanted, place = self.cases[case], list(self.cells).index(cell)
        choices = wanted.possible(cell)
        for k in repetitions_of(repetitions):
            seed = wanted.first_seed + k * len(self.cells) + place
            chosen = [choices[i] for i in _drawn(len(choices), wanted.together, seed)]
            for size in wanted.sizes:
                planted = tuple({**c.entry, "size": float(size * c.natural)} for c in chosen)
                yield Set(case, wanted.kind, cell, seed, size, planted, wanted.dirt, wanted.overrides)


def repetitions_of(name: str) -> range:
    """Return the repetitions, from 0, of a job's name: ``001-002`` is the first and the second."""
    first, last = map(int, name.split("-"))
    return range(first - 1, last)


def _drawn(n: int, together: int, seed: int) -> Sequence[int]:
    """Return which of n choices a seed plants, in the order of planting."""
    if together >= n:
        return range(n)
    return np.random.default_rng([seed, n, together]).permutation(n)[:together].tolist()


def load_study(path: str | Path) -> Study:
    """Return the closed loop that a YAML file describes.

    Raises:
        InvalidInput: With every fault found; a misspelt key is named.
    """
    content, file = load_yaml(Path(path)), Path(path).name
    validator = jsonschema.Draft202012Validator(json.loads(SCHEMA.read_text(encoding="utf-8")))
    faults = [
        Fault(file, error.message.splitlines()[0], column=".".join(map(str, error.absolute_path)))
        for error in validator.iter_errors(content)
    ]
    if faults:
        raise InvalidInput(faults)
    faults = [Fault(file, message, column=place) for place, message in _contradictions(content)]
    if faults:
        raise InvalidInput(faults)
    return Study(
        scene=content["scene"],
        cells={name: {"overrides": {}, **cell} for name, cell in content["cells"].items()},
        cases={case.name: case for case in _cases(content)},
        units={name: effect["unit"] for name, effect in content["single"]["effects"].items()},
        seeds_per_job=content["seeds_per_job"],
    )


def _contradictions(content: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Yield (place, message) for names that stand for nothing."""
    cells, effects = content["cells"], content["single"]["effects"]
    for where, block in (("single.effects", effects), ("unknown.kinds", content["unknown"]["kinds"])):
        for name, entry in block.items():
            for cell in entry.get("cells", ()):
                if cell not in cells:
                    yield f"{where}.{name}.cells", f"no cell {cell!r}; there are {', '.join(cells)}"
    for name in content["pairs"]["effects"]:
        if name not in effects:
            yield "pairs.effects", f"{name!r} is not among single.effects"


def _cases(content: Mapping[str, Any]) -> Iterator[Case]:
    """Yield the cases of a checked config."""
    cells = tuple(content["cells"])

    def choice(name: str, block: Mapping[str, Any]) -> Choice:
        entry = block.get("planted", {"effect": name})
        return Choice(entry, float(block["natural"]), tuple(block.get("cells", cells)))

    single, null, pairs, unknown = (content[kind] for kind in ("single", "null", "pairs", "unknown"))
    seeds = single["first_seed"], single["seeds"]
    for name, block in single["effects"].items():
        sizes = tuple(block.get("sizes", single["sizes"]))
        overrides = block.get("overrides", {})
        yield Case(name, "single", (choice(name, block),), 1, sizes, *seeds, overrides=overrides)
    for name, block in null["cases"].items():
        planted = tuple(
            Choice({"effect": entry["effect"]}, float(entry["size"]), cells)
            for entry in block.get("planted", ())
        )
        seeds = block["first_seed"], null["seeds"]
        yield Case(f"null-{name}", "null", planted, len(planted), (1.0,), *seeds, block.get("dirt", {}))
    two = tuple(choice(name, single["effects"][name]) for name in pairs["effects"])
    yield Case("pairs", "pair", two, 2, tuple(pairs["sizes"]), pairs["first_seed"], pairs["seeds"])
    for name, block in unknown["kinds"].items():
        kind = choice(name, {"planted": {"effect": "unknown", "kind": name}, **block})
        sizes = tuple(unknown["sizes"])
        yield Case(f"unknown-{name}", "unknown", (kind,), 1, sizes, block["first_seed"], unknown["seeds"])
