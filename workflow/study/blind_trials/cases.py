"""Read and check the config of the blind trials, and list the sets to simulate for every case and workcell.

A *case* is one experiment: an effect in several sizes, gross errors or noise without a systematic effect, pairs of effects, or an effect that has no
name in the catalogue. A *workcell* is a robot with a scanner among target planes. A *set* is one dataset of a case in a workcell, with a seed and a
size of its own.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from scalar.data.io.plain_yaml import load_yaml
from scalar.errors import Fault, InvalidInput
from study.common.renamed import renamed_faults
from study.common.schema_faults import refuse_by_schema

SCHEMA = Path(__file__).parent / "schemas/blind_trials.schema.json"


@dataclass(frozen=True)
class Choice:
    """An effect that may be injected.

    Attributes:
        entry: Its entry for the scene's key ``injected``, without the size.
        natural: Its natural size, in the unit that the config states.
        workcells: Names of the workcells into which it can be injected.
    """

    entry: Mapping[str, Any]
    natural: float
    workcells: tuple[str, ...]


@dataclass(frozen=True)
class Case:
    """One experiment of the blind trials.

    Attributes:
        name: The key in the config, prefixed by ``null-`` or ``unknown-`` for these kinds, or ``pairs``; part of names of files.
        kind: ``single``, ``null``, ``pair`` or ``unknown``.
        choices: The effects that may be injected.
        together: Number of effects that a set injects; if there are more choices, the seed of the set decides which.
        sizes: Multiples of the natural size; there is a set for each.
        first_seed: Seed of repetition 0 in the first workcell.
        repetitions: Number of repetitions in each workcell, each with a seed of its own.
        gross_errors: Shares of stray points (``points``), corrupted poses (``poses``) and wrong labels (``labels``).
        overrides: ``{dotted key: value}``, keys of the scene that this case replaces.
    """

    name: str
    kind: str
    choices: tuple[Choice, ...]
    together: int
    sizes: tuple[float, ...]
    first_seed: int
    repetitions: int
    gross_errors: Mapping[str, float] = field(default_factory=dict)
    overrides: Mapping[str, Any] = field(default_factory=dict)

    def possible(self, workcell: str) -> list[Choice]:
        """Return the choices that can be injected in a workcell."""
        return [choice for choice in self.choices if workcell in choice.workcells]


@dataclass(frozen=True)
class Set:
    """One dataset to make and to diagnose.

    Attributes:
        case: Name of the case.
        kind: Kind of the case.
        workcell: Name of the workcell.
        seed: Seed of all random draws in the set.
        size: Multiple of the natural size.
        injected: Entries of the scene's key ``injected``, sizes included.
        gross_errors: As in ``Case``.
        overrides: As in ``Case``.
    """

    case: str
    kind: str
    workcell: str
    seed: int
    size: float
    injected: tuple[Mapping[str, Any], ...]
    gross_errors: Mapping[str, float]
    overrides: Mapping[str, Any]


@dataclass(frozen=True)
class Study:
    """All blind trials of a config.

    Attributes:
        scene: ``{dotted key: value}``, keys that are replaced in every scene.
        workcells: ``{name: {"scene": file, "overrides": {dotted key: value}}}``.
        cases: ``{name: case}``, in the order of the config.
        units: ``{case of a single effect: unit of its size}``.
        seeds_per_job: Number of seeds that one job runs; no result depends on it.
    """

    scene: Mapping[str, Any]
    workcells: Mapping[str, Mapping[str, Any]]
    cases: Mapping[str, Case]
    units: Mapping[str, str]
    seeds_per_job: int

    def jobs(self) -> list[tuple[str, str, str]]:
        """Return (case, workcell, repetitions) of every job; the repetitions are a text that ``repetitions_of`` reads, such as ``001-002``."""
        return [
            (case.name, workcell, f"{k + 1:03d}-{min(k + self.seeds_per_job, case.repetitions):03d}")
            for case in self.cases.values()
            for workcell in self.workcells
            if len(case.possible(workcell)) >= case.together
            for k in range(0, case.repetitions, self.seeds_per_job)
        ]

    def sets(self, case: str, workcell: str, repetitions: str) -> Iterator[Set]:
        """Yield the sets of one job, seed by seed.

        The seed of repetition k in workcell i of n (both from 0) is ``first_seed + k * n + i``: further repetitions change no set that exists.
        """
        wanted, place = self.cases[case], list(self.workcells).index(workcell)
        choices = wanted.possible(workcell)
        for k in repetitions_of(repetitions):
            seed = wanted.first_seed + k * len(self.workcells) + place
            chosen = [choices[i] for i in _drawn(len(choices), wanted.together, seed)]
            for size in wanted.sizes:
                injected = tuple({**c.entry, "size": float(size * c.natural)} for c in chosen)
                yield Set(
                    case, wanted.kind, workcell, seed, size, injected, wanted.gross_errors, wanted.overrides
                )


def repetitions_of(name: str) -> range:
    """Return the repetitions, counted from 0, that a job's name states counted from 1: 0 and 1 for ``001-002``."""
    first, last = map(int, name.split("-"))
    return range(first - 1, last)


def _drawn(n: int, together: int, seed: int) -> Sequence[int]:
    """Return the indices of the choices, ``together`` of n, that are injected with a seed, in the order in which they are injected."""
    if together >= n:
        return range(n)
    return np.random.default_rng([seed, n, together]).permutation(n)[:together].tolist()


def load_study(path: str | Path) -> Study:
    """Return the blind trials that a YAML file describes.

    Raises:
        InvalidInput: The file is at fault. Renamed keys, the schema and undefined names are checked in turn; every fault of the first check that
            fails is listed.
    """
    content, file = load_yaml(Path(path)), Path(path).name
    if renamed := renamed_faults(content):
        raise InvalidInput([Fault(file, message) for message in renamed])
    refuse_by_schema(content, SCHEMA, file)
    faults = [Fault(file, message, column=place) for place, message in _contradictions(content)]
    if faults:
        raise InvalidInput(faults)
    return Study(
        scene=content["scene"],
        workcells={name: {"overrides": {}, **workcell} for name, workcell in content["workcells"].items()},
        cases={case.name: case for case in _cases(content)},
        units={name: effect["unit"] for name, effect in content["single"]["effects"].items()},
        seeds_per_job=content["seeds_per_job"],
    )


def _contradictions(content: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Yield (place, message) for names of workcells and effects that the config does not define."""
    workcells, effects = content["workcells"], content["single"]["effects"]
    for where, block in (("single.effects", effects), ("unknown.kinds", content["unknown"]["kinds"])):
        for name, entry in block.items():
            for workcell in entry.get("workcells", ()):
                if workcell not in workcells:
                    yield (
                        f"{where}.{name}.workcells",
                        f"no workcell {workcell!r}; there are {', '.join(workcells)}",
                    )
    for name in content["pairs"]["effects"]:
        if name not in effects:
            yield "pairs.effects", f"{name!r} is not among single.effects"


def _cases(content: Mapping[str, Any]) -> Iterator[Case]:
    """Yield the cases of a checked config."""
    workcells = tuple(content["workcells"])

    def choice(name: str, block: Mapping[str, Any]) -> Choice:
        entry = block.get("injected", {"effect": name})
        return Choice(entry, float(block["natural"]), tuple(block.get("workcells", workcells)))

    single, null, pairs, unknown = (content[kind] for kind in ("single", "null", "pairs", "unknown"))
    seed_range = single["first_seed"], single["seeds"]
    for name, block in single["effects"].items():
        sizes = tuple(block.get("sizes", single["sizes"]))
        overrides = block.get("overrides", {})
        yield Case(name, "single", (choice(name, block),), 1, sizes, *seed_range, overrides=overrides)
    for name, block in null["cases"].items():
        injected = tuple(
            Choice({"effect": entry["effect"]}, float(entry["size"]), workcells)
            for entry in block.get("injected", ())
        )
        seed_range = block["first_seed"], null["seeds"]
        yield Case(
            f"null-{name}",
            "null",
            injected,
            len(injected),
            (1.0,),
            *seed_range,
            block.get("gross_errors", {}),
        )
    two = tuple(choice(name, single["effects"][name]) for name in pairs["effects"])
    yield Case("pairs", "pair", two, 2, tuple(pairs["sizes"]), pairs["first_seed"], pairs["seeds"])
    for name, block in unknown["kinds"].items():
        chosen = choice(name, {"injected": {"effect": "unknown", "kind": name}, **block})
        sizes = tuple(unknown["sizes"])
        yield Case(f"unknown-{name}", "unknown", (chosen,), 1, sizes, block["first_seed"], unknown["seeds"])
