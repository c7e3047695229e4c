"""The design of the stratified blind trials: sets that cross scanners, surfaces, effects, numbers of poses and robots.

The *conditions* of a set are one level of each of these factors. They are assigned to one set after the other: of some random candidates, that one is
taken whose pairs of levels have occurred least so far. So every pair of levels occurs, about as often as every other pair of the same two factors (a
covering array of strength two, built greedily). Everything else of a set is drawn from the design's seed and the set's number.
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
"""Number of random conditions from which those of a set are chosen; with 60, the numbers of all pairs agree within a few per cent."""
N_INJECTED = {"none": 0, "one": 1, "three": 3, "four": 4, "five": 5, "cause": 1, "shape": 1}
"""``{level of the factor injected: number of effects, causes without a name, or shapes that are injected}``."""


@dataclass(frozen=True)
class Trial:
    """One set: its conditions and what is drawn for them.

    Attributes:
        number: Number of the set, from 0.
        seed: Seed of the scene.
        conditions: ``{factor: level}`` for each of ``FACTORS``.
        overrides: ``{dotted key: value}``, keys of the scene that are replaced; the number of poses is in the conditions.
        injected: Entries of the scene's key ``injected``.
    """

    number: int
    seed: int
    conditions: Mapping[str, Any]
    overrides: Mapping[str, Any]
    injected: tuple[Mapping[str, Any], ...]

    @property
    def row(self) -> str:
        """Return the name of the row of the table of rates in which the set is counted."""
        return row_of(self.conditions)


def row_of(conditions: Mapping[str, Any]) -> str:
    """Return the name of the row of the table of rates to which conditions belong."""
    injected, poses = conditions["injected"], conditions["poses"]
    ideal = conditions["scanner"] == "white" and conditions["surface"] == "flat"
    if injected in ("cause", "shape"):
        return {"cause": "unknown cause", "shape": "shape also tried"}[injected]
    if poses <= 60:
        return "60 poses"
    if N_INJECTED[injected] >= 3:
        return "3 to 5 effects"
    if injected == "one":
        return "one effect, ideal" if ideal else "one effect, imperfect"
    return "no effect, ideal" if ideal else "no effect, imperfect"


@dataclass(frozen=True)
class Design:
    """The stratified trials of a config.

    Attributes:
        content: Content of the config.
    """

    content: Mapping[str, Any]

    def trials(self, sets: int | None = None) -> list[Trial]:
        """Return all trials, or the first ``sets`` of them."""
        content = self.content
        assigned = assigned_conditions(self.levels(), sets or content["sets"], content["seed"])
        return [self.trial(k, conditions) for k, conditions in enumerate(assigned)]

    @property
    def outer_split(self) -> int:
        """Return the number of parts of the outer split of each diagnosis; zero if these trials do without it."""
        return int(self.content.get("outer_split", 0))

    def levels(self) -> dict[str, list[Any]]:
        """Return ``{factor: its levels}``."""
        content = self.content
        return {
            "scanner": list(content["scanners"]),
            "surface": list(content["surfaces"]),
            "injected": list(content["injected"]),
            "poses": list(content["poses"]),
            "robot": list(content["robots"]),
        }

    def jobs(self) -> list[str]:
        """Return the names of the jobs, as ``numbers_of`` reads them: ``0000-0009`` runs the first ten sets."""
        return job_names(self.content["sets"], self.content["sets_per_job"])

    def trial(self, number: int, conditions: Mapping[str, Any], attempt: int = 0) -> Trial:
        """Return a trial; what its conditions leave open is drawn from the design's seed, the number and the attempt.

        Args:
            number: Number of the set.
            conditions: ``{factor: level}``.
            attempt: Number of scenes of this set that could not be simulated.
        """
        content = self.content
        rng = np.random.default_rng([content["seed"], number, attempt])
        robot = content["robots"][conditions["robot"]]
        overrides: dict[str, Any] = dict(content["scene"])
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
            picked = rng.choice(names, N_INJECTED[kind], replace=False)
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
    """Return a value of the config as it is; if it is ``{between: [low, high]}``, return a number drawn between these, uniformly in its logarithm."""
    if not isinstance(value, Mapping):
        return value
    low, high = np.log(value["between"])
    return float(np.exp(rng.uniform(low, high)))


def assigned_conditions(levels: Mapping[str, Sequence[Any]], sets: int, seed: int) -> list[dict[str, Any]]:
    """Return the conditions of each set, with pairs of levels as evenly frequent as a greedy choice makes them.

    The conditions of a set do not depend on the number of sets that follow it.

    Args:
        levels: ``{factor: its levels}``.
        sets: Number of sets.
        seed: Seed of the random candidates.
    """
    rng = np.random.default_rng([seed, len(FACTORS)])
    counts = np.array([len(levels[factor]) for factor in FACTORS])
    pairs = list(combinations(range(len(FACTORS)), 2))
    # How often each pair of levels has occurred, relative to how often it would if all pairs of its factors were equally frequent.
    seen = {(i, j): np.zeros((counts[i], counts[j])) for i, j in pairs}
    assigned = []
    for _ in range(sets):
        candidates = (rng.random((CANDIDATES, len(FACTORS))) * counts).astype(int)
        so_far = sum(seen[i, j][candidates[:, i], candidates[:, j]] for i, j in pairs)
        best = candidates[int(np.argmin(so_far))]
        for i, j in pairs:
            seen[i, j][best[i], best[j]] += counts[i] * counts[j]
        assigned.append({factor: levels[factor][k] for factor, k in zip(FACTORS, best, strict=True)})
    return assigned


def pairs_of(conditions: Mapping[str, Any]) -> list[tuple[Any, ...]]:
    """Return all pairs of levels that occur in the conditions of a set: (factor, level, factor, level)."""
    return [(a, conditions[a], b, conditions[b]) for a, b in combinations(FACTORS, 2)]


def job_names(sets: int, size: int) -> list[str]:
    """Return the names of the jobs that run ``sets`` sets, ``size`` of them in each."""
    return [f"{k:04d}-{min(k + size, sets) - 1:04d}" for k in range(0, sets, size)]


def numbers_of(job: str) -> range:
    """Return the numbers of the sets of a job by its name."""
    first, last = map(int, job.split("-"))
    return range(first, last + 1)


def load_design(path: str | Path) -> Design:
    """Return the design that a YAML file describes; ``extends`` is explained at ``checked_config``.

    Raises:
        InvalidInput: The file is at fault; every fault is listed.
    """
    return Design(checked_config(path, SCHEMA))


def checked_config(path: str | Path, schema: Path) -> dict[str, Any]:
    """Return the content of a YAML file that fits a JSON schema.

    If the file names another one in its folder under the key ``extends``, it needs to state only what differs: the content is that of the other
    file, with the keys of this one replaced.

    Raises:
        InvalidInput: The file is at fault; every fault is listed.
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
