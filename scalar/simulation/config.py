"""The config of a scene: it is read, checked against its schema and completed with the schema's defaults.

Keys, units and defaults are stated in the schema alone. A key that the schema does not have is refused by name.
"""

import copy
import difflib
import json
import math
from collections.abc import Mapping
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any

import jsonschema

from scalar.data.io.plain_yaml import LARGEST, join_path, load_yaml
from scalar.data.schema_words import in_plain_words
from scalar.data.strict_schema import strict_validator
from scalar.errors import Fault, InvalidInput
from scalar.simulation.injected_checks import injected_faults

ROBOT_PARAMETERS = ("a", "d", "alpha", "theta", "beta")
LENGTHS = ("a", "d")
RENAMED = {"planted": "injected", "course": "profile"}
"""Former names of keys, and their present ones."""
SENSOR_PARAMETERS = ("sensor_x", "sensor_y", "sensor_z", "sensor_rx", "sensor_ry", "sensor_rz")


@cache
def scene_schema() -> dict[str, Any]:
    """Return the JSON schema of a scene config."""
    text = resources.files("scalar.simulation").joinpath("schemas/scene.schema.json").read_text("utf-8")
    return json.loads(text)


def load_config(
    path: Path, *, robot: Mapping[str, Any] | None = None, robot_file: str | None = None
) -> dict[str, Any]:
    """Return the scene config in a YAML file, complete, with the robot's own file read into it.

    Args:
        path: The file.
        robot: The ``robot:`` block of a dataset.yaml that takes the place of the config's own robot; None to keep that.
        robot_file: Name of the file from which it was made, for messages.

    Raises:
        InvalidInput: with every fault found; a misspelt key is named.
    """
    path = Path(path)
    content = load_yaml(path)
    if robot is not None and isinstance(content, dict):
        _check_robot(robot, robot_file or path.name)
        content = {**content, "robot": dict(robot)}
    return complete_config(content, base_dir=path.parent, file=path.name)


def complete_config(config: Any, *, base_dir: Path | None = None, file: str = "config") -> dict[str, Any]:
    """Return a copy of a config with all defaults filled in and `robot` as a mapping.

    Args:
        config: as read from YAML.
        base_dir: the folder to which the path of a robot file is relative; None for the working directory.
        file: name of the config in messages.

    Raises:
        InvalidInput: with every fault found.
    """
    _check(config, scene_schema(), file)
    config = copy.deepcopy(config)
    if isinstance(config["robot"], str):
        robot_path = Path(base_dir or ".") / config["robot"]
        config["robot"] = load_yaml(robot_path)
        _check_robot(config["robot"], robot_path.name)
    _fill(config, scene_schema())
    faults = [Fault(file, message, column=place) for place, message in _contradictions(config)]
    if faults:
        raise InvalidInput(faults)
    return config


def _check_robot(robot: Any, file: str) -> None:
    """Raise InvalidInput with every fault of a robot block."""
    _check(robot, {"$defs": scene_schema()["$defs"], "$ref": "#/$defs/robot"}, file)


def parameter_names(n: int) -> list[str]:
    """Return the names of all parameters of n joints and a sensor, in the order in which errors are drawn."""
    return [f"{name}_{i + 1}" for name in ROBOT_PARAMETERS for i in range(n)] + list(SENSOR_PARAMETERS)


def length_names(n: int) -> list[str]:
    """Return the names of the lengths of n joints: a_1 .. a_n, d_1 .. d_n."""
    return [f"{name}_{i + 1}" for name in LENGTHS for i in range(n)]


def poses_wanted(config: Mapping[str, Any]) -> list[int]:
    """Return the number of poses of each plane, in the planes' order."""
    wanted = config["poses_per_plane"]
    return [wanted if isinstance(wanted, int) else wanted[plane["name"]] for plane in config["planes"]]


def _contradictions(config: dict[str, Any]) -> list[tuple[str, str]]:
    """Return the faults that a schema cannot find, as (path of the key, message)."""
    found: list[tuple[str, str]] = []
    names = [plane["name"] for plane in config["planes"]]
    for k, name in enumerate(names):
        if name in names[:k]:
            found.append((f"planes[{k}].name", f"{name!r} is the name of two planes; give each its own"))
    for k, plane in enumerate(config["planes"]):
        if not math.hypot(*plane["normal"]) > 0:
            found.append((f"planes[{k}].normal", "is zero; give the direction of the normal"))
    wanted = config["poses_per_plane"]
    if isinstance(wanted, dict) and set(wanted) != set(names):
        found.append(("poses_per_plane", f"name each of the planes once: {', '.join(names)}"))
    near, far = config["sensor"]["range_m"]
    if not near < far:
        found.append(("sensor.range_m", f"[{near}, {far}]: the near limit comes first and is the smaller"))
    if (
        config["sensor"]["selection"] == "random"
        and config["sensor"]["rays"] < config["sensor"]["points_per_scan"]
    ):
        found.append(("sensor.rays", "fewer than points_per_scan; choose among at least as many rays"))
    for k, joint in enumerate(config["robot"]["joints"]):
        low, high = joint.get("limits", (-1, 1))
        if not low < high:
            found.append((f"robot.joints[{k}].limits", "the lower limit comes first and is the smaller"))
    n = len(config["robot"]["joints"])
    for key in ("links_kg", "centres_m"):
        given = config["masses"][key]
        if given is not None and len(given) != n:
            found.append((f"masses.{key}", f"{len(given)} for {n} joints; give one for the link behind each"))
    by_name = dict(zip(names, poses_wanted(config), strict=True)) if len(found) == 0 else {}
    if by_name:
        found += injected_faults(config["injected"], n, by_name, length_names(n))
    if "true_robot_errors" in config and "initial_model" in config:
        found.append(
            (
                "initial_model",
                "is given together with true_robot_errors; perturb the arm or the model, not both",
            )
        )
    known = parameter_names(n)
    for block in ("true_robot_errors", "initial_model"):
        for name in config.get(block, {}).get("exact", ()):
            if name not in known:
                found.append((f"{block}.exact", f"{name!r} is no parameter{_meant(name, known)}"))
    return found


def _meant(word: str, known: list[str]) -> str:
    """Return the known name that is most like a word, as the end of a message, or all known names."""
    close = difflib.get_close_matches(word, known, n=1)
    return f"; did you mean {close[0]!r}?" if close else f"; known: {', '.join(known)}"


def _check(config: Any, schema: dict[str, Any], file: str) -> None:
    """Raise InvalidInput with a fault for everything in `config` that the schema refuses."""
    validator = strict_validator(schema)
    faults = [
        fault
        for error in sorted(
            validator.iter_errors(config), key=lambda e: [str(key) for key in e.absolute_path]
        )
        for fault in _faults(error, file)
    ]
    message = "is not a finite number of at most 1e300"
    faults += [Fault(file, message, column=place) for place in _not_finite(config, ())]
    if faults:
        raise InvalidInput(faults)


def _faults(error: Any, file: str) -> list[Fault]:
    """Return the faults that one error of the schema's validator stands for."""
    place = join_path(tuple(error.absolute_path))
    if error.validator == "additionalProperties" and isinstance(error.instance, dict):
        known = list(error.schema.get("properties", {}))
        unknown = [key for key in error.instance if key not in known]
        prefix = f"{place}." if place else ""
        return [Fault(file, _unknown(key, known), column=prefix + key) for key in unknown]
    messages = in_plain_words(error)
    return [Fault(file, message, column=join_path(path) or None) for path, message in messages]


def _unknown(key: str, known: list[str]) -> str:
    """Return the message for a key that the schema does not have; for a former name it gives the present one."""
    present = RENAMED.get(key)
    if present in known:
        return f"the key {key!r} is now called {present!r}; rename it"
    return f"unknown key {key!r}{_meant(key, known)}"


def _not_finite(value: Any, path: tuple[str | int, ...]) -> list[str]:
    """Return the paths of all numbers that are not finite or too large."""
    if isinstance(value, int | float) and not abs(value) <= LARGEST:
        return [join_path(path)]
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    return [place for key, item in items for place in _not_finite(item, (*path, key))]


def _fill(value: Any, schema: dict[str, Any]) -> None:
    """Fill the schema's defaults into `value`, in place, at every depth."""
    if "$ref" in schema:
        schema = scene_schema()["$defs"][schema["$ref"].removeprefix("#/$defs/")]
    if isinstance(value, dict):
        for branch in schema.get("allOf", ()):
            if jsonschema.Draft202012Validator(branch["if"]).is_valid(value):
                _fill(value, branch["then"])
        for key, sub in schema.get("properties", {}).items():
            if key not in value and "default" in sub:
                value[key] = copy.deepcopy(sub["default"])
            if key in value:
                _fill(value[key], sub)
    elif isinstance(value, list) and isinstance(schema.get("items"), dict):
        for item in value:
            _fill(item, schema["items"])
