"""What the blind trials run: its config, checked, and for every case and workcell the sets to make.

A case is one thing to try (an effect over its sizes, gross errors or noise without a systematic effect, pairs of effects, an effect of no
known name); a workcell is a robot with a scanner among target planes; a set is one dataset of a case in a workcell, with a seed
and a size of its own.
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
    """Something that may be injected.

    Attributes:
        entry: An entry for the scene's ``injected``, its size left out.
        natural: Size [unit] that the multiple 1 stands for.
        workcells: Where it can be injected.
    """

    entry: Mapping[str, Any]
    natural: float
    workcells: tuple[str, ...]


@dataclass(frozen=True)
class Case:
    """One thing to try.

    Attributes:
        name: Usable in a file name: the key in the config, prefixed by ``null-`` or ``unknown-`` for these kinds, or ``pairs``.
        kind: ``single``, ``null``, ``pair`` or ``unknown``.
        choices: What may be injected.
        together: How many of them a set injects; drawn from its seed where there are more.
        sizes: Multiples of the natural size; a set each.
        first_seed: Seed of repetition 0 in the first workcell.
        repetitions: How many seeds each workcell has, one a repetition.
        gross_errors: Shares of stray points, corrupted poses and wrong labels.
        overrides: ``{dotted key: value}`` of the scene, for this case alone.
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
        case, kind, workcell: As above, by name.
        seed: Of all random draws in it.
        size: Multiple of the natural size.
        injected: Entries of the scene's ``injected``, sizes included.
        gross_errors, overrides: As above.
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
        scene: ``{dotted key: value}`` of every scene.
        workcells: ``{name: {"scene": file, "overrides": {dotted key: value}}}``.
        cases: By name, in the order of the config.
        units: ``{case of a single effect: unit of its size}``.
        seeds_per_job: How many seeds one job takes; changes no result.
    """

    scene: Mapping[str, Any]
    workcells: Mapping[str, Mapping[str, Any]]
    cases: Mapping[str, Case]
    units: Mapping[str, str]
    seeds_per_job: int

    def jobs(self) -> list[tuple[str, str, str]]:
        """Return (case, workcell, repetitions) of every job; repetitions as ``repetitions_of`` reads them, ``001-002``."""
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
    """Return the repetitions, from 0, of a job's name: ``001-002`` is the first and the second."""
    first, last = map(int, name.split("-"))
    return range(first - 1, last)


def _drawn(n: int, together: int, seed: int) -> Sequence[int]:
    """Return which of n choices a seed injects, in the order of injecting."""
    if together >= n:
        return range(n)
    return np.random.default_rng([seed, n, together]).permutation(n)[:together].tolist()


def load_study(path: str | Path) -> Study:
    """Return the blind trials that a YAML file describes.

    Raises:
        InvalidInput: With every fault of the first check that fails: renamed keys, schema, undefined names.
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
