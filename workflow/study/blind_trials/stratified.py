"""The design of the stratified blind trials: sets that cross scanners, surfaces, effects, numbers of poses and robots.

Each set is drawn from the seed and its number alone once the conditions are dealt. Conditions are dealt one set after the other: of
some candidates that one is taken whose pairs of conditions have occurred least, so every pair of conditions occurs, and about as
often as every other of its two factors (a covering array of strength two, built greedily).
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np

from scalar.data.io.plain_yaml import load_yaml
from scalar.data.io.regular_file import path_inside
from scalar.data.strict_schema import strict_validator
from scalar.errors import Fault, InvalidInput

SCHEMA = Path(__file__).parent / "schemas/stratified.schema.json"
FACTORS = ("scanner", "surface", "injected", "poses", "robot")
CANDIDATES = 60
"""Random conditions of which the one is dealt whose pairs are rarest; with 60, pairs come out even within a few per cent."""
TOGETHER = {"none": 0, "one": 1, "three": 3, "four": 4, "five": 5, "cause": 1, "shape": 1}
"""By level of ``injected``: how many effects, causes or shapes a set has."""
PLANES = 3  # of every scene


@dataclass(frozen=True)
class Trial:
    """One set: its conditions and what is drawn for them.

    Attributes:
        number: Of the set, from 0; with the design's seed it determines all random draws of the set.
        seed: Of the scene.
        conditions: A level of each of ``FACTORS``.
        overrides: ``{dotted key: value}`` of the scene. injected: Entries of its ``injected``.
    """

    number: int
    seed: int
    conditions: Mapping[str, Any]
    overrides: Mapping[str, Any]
    injected: tuple[Mapping[str, Any], ...]

    @property
    def row(self) -> str:
        """Return the row of the table in which the set is counted."""
        return row_of(self.conditions)


def row_of(conditions: Mapping[str, Any]) -> str:
    """Return the row of the table that conditions belong to."""
    injected, poses = conditions["injected"], conditions["poses"]
    ideal = conditions["scanner"] == "white" and conditions["surface"] == "flat"
    if injected in ("cause", "shape"):
        return {"cause": "unknown cause", "shape": "shape also tried"}[injected]
    if poses <= 60:
        return "60 poses"
    if TOGETHER[injected] >= 3:
        return "3 to 5 effects"
    if injected == "one":
        return "one effect, ideal" if ideal else "one effect, imperfect"
    return "no effect, ideal" if ideal else "no effect, imperfect"


@dataclass(frozen=True)
class Design:
    """The stratified trials of a config."""

    content: Mapping[str, Any]

    def trials(self, sets: int | None = None) -> list[Trial]:
        """Return all trials, or the first ``sets`` of them."""
        content = self.content
        dealt = dealt_conditions(self.levels(), sets or content["sets"], content["seed"])
        return [self.trial(k, conditions) for k, conditions in enumerate(dealt)]

    def levels(self) -> dict[str, list[Any]]:
        """Return the levels of each factor."""
        content = self.content
        return {
            "scanner": list(content["scanners"]),
            "surface": list(content["surfaces"]),
            "injected": list(content["injected"]),
            "poses": list(content["poses"]),
            "robot": list(content["robots"]),
        }

    def jobs(self) -> list[str]:
        """Return the sets of each job: ``0000-0009`` is the first ten, as ``numbers_of`` reads it."""
        return job_names(self.content["sets"], self.content["sets_per_job"])

    def trial(self, number: int, conditions: Mapping[str, Any], attempt: int = 0) -> Trial:
        """Return the trial of these conditions: what they leave open is drawn from the seed, the number and the attempt."""
        content = self.content
        rng = np.random.default_rng([content["seed"], number, attempt])
        robot = content["robots"][conditions["robot"]]
        overrides: dict[str, Any] = dict(content["scene"]) | {
            "poses_per_plane": conditions["poses"] // PLANES
        }
        for block in (
            content["scanners"][conditions["scanner"]],
            content["surfaces"][conditions["surface"]],
            robot.get("overrides", {}),
        ):
            overrides |= {key: _drawn(value, rng) for key, value in block.items()}
        names = [name for name in content["effects"] if name not in robot.get("without", ())]
        kind = conditions["injected"]
        low, high = content["sizes"]
        if kind in ("cause", "shape"):
            of_kind = content[f"{kind}s"]
            name = str(rng.choice(list(of_kind)))
            chosen = [({"effect": "unknown", "kind": name}, of_kind[name])]
        else:
            picked = rng.choice(names, TOGETHER[kind], replace=False)
            times = robot.get("times", {})
            chosen = [
                ({"effect": str(name)}, content["effects"][str(name)] * times.get(str(name), 1.0))
                for name in picked
            ]
        injected = tuple(
            {**entry, "size": float(natural * np.exp(rng.uniform(np.log(low), np.log(high))))}
            for entry, natural in chosen
        )
        return Trial(number, int(rng.integers(2**31)), dict(conditions), overrides, injected)


def _drawn(value: Any, rng: np.random.Generator) -> Any:
    """Return a value as it stands, or drawn where it is ``{between: [low, high]}``."""
    if not isinstance(value, Mapping):
        return value
    low, high = np.log(value["between"])
    return float(np.exp(rng.uniform(low, high)))


def dealt_conditions(levels: Mapping[str, Sequence[Any]], sets: int, seed: int) -> list[dict[str, Any]]:
    """Return the conditions of each set, pairs as even as a greedy deal makes them; a longer deal begins with a shorter one."""
    rng = np.random.default_rng([seed, len(FACTORS)])
    counts = np.array([len(levels[factor]) for factor in FACTORS])
    pairs = list(combinations(range(len(FACTORS)), 2))
    # How often each pair has occurred, over its fair share.
    seen = {(i, j): np.zeros((counts[i], counts[j])) for i, j in pairs}
    dealt = []
    for _ in range(sets):
        candidates = (rng.random((CANDIDATES, len(FACTORS))) * counts).astype(int)
        so_far = sum(seen[i, j][candidates[:, i], candidates[:, j]] for i, j in pairs)
        best = candidates[int(np.argmin(so_far))]
        for i, j in pairs:
            seen[i, j][best[i], best[j]] += counts[i] * counts[j]
        dealt.append({factor: levels[factor][k] for factor, k in zip(FACTORS, best, strict=True)})
    return dealt


def pairs_of(conditions: Mapping[str, Any]) -> list[tuple[Any, ...]]:
    """Return all pairs of conditions: (factor, level, factor, level)."""
    return [(a, conditions[a], b, conditions[b]) for a, b in combinations(FACTORS, 2)]


def job_names(sets: int, size: int) -> list[str]:
    """Return the names of the jobs of so many sets, ``size`` to a job."""
    return [f"{k:04d}-{min(k + size, sets) - 1:04d}" for k in range(0, sets, size)]


def numbers_of(job: str) -> range:
    """Return the numbers of the sets of a job."""
    first, last = map(int, job.split("-"))
    return range(first, last + 1)


def load_design(path: str | Path) -> Design:
    """Return the design that a YAML file describes; where it ``extends`` another in its folder, its keys replace that one's.

    Raises:
        InvalidInput: With every fault found.
    """
    return Design(checked_config(path, SCHEMA))


def checked_config(path: str | Path, schema: Path) -> dict[str, Any]:
    """Return the content of a YAML file by a JSON schema; where it ``extends`` another in its folder, its keys replace that one's.

    Raises:
        InvalidInput: With every fault found.
    """
    content, file = load_yaml(Path(path)), Path(path).name
    if isinstance(content, dict) and isinstance(content.get("extends"), str):
        base = load_yaml(path_inside(Path(path).parent, content["extends"], file, "extends"))
        if not isinstance(base, dict):
            raise InvalidInput(Fault(file, "names a file that holds no design; correct it", column="extends"))
        content = base | {key: value for key, value in content.items() if key != "extends"}
    validator = strict_validator(json.loads(schema.read_text(encoding="utf-8")))
    faults = [
        Fault(file, error.message.splitlines()[0], column=".".join(map(str, error.absolute_path)))
        for error in validator.iter_errors(content)
    ]
    if faults:
        raise InvalidInput(faults)
    return content
