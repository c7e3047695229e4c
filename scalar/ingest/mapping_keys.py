"""The keys of a mapping for `scalar import`, from the schema that checks it."""

from __future__ import annotations

import json
from collections.abc import Iterator
from importlib import resources
from typing import Any

SCHEMA = "schemas/mapping.schema.json"


def keys_of_a_mapping() -> list[tuple[str, str]]:
    """Return every key of a mapping and what it means."""
    schema = json.loads(resources.files("scalar.ingest").joinpath(SCHEMA).read_text(encoding="utf-8"))
    return list(keys(schema))


def keys(schema: dict[str, Any]) -> Iterator[tuple[str, str]]:
    """Return each key of a schema with its description; keys inside others follow them, with dots."""
    yield from _below(schema, schema, "")


def _below(schema: dict[str, Any], part: dict[str, Any], above: str) -> Iterator[tuple[str, str]]:
    """Yield path and description of every key below a part of a schema; ``above`` is the path of that part."""
    for name, own in part.get("properties", {}).items():
        inner = _resolved(schema, own)
        yield f"{above}{name}", str(inner.get("description", ""))
        content = _resolved(schema, inner.get("items", {}))
        yield from _below(schema, inner, f"{above}{name}.")
        yield from _below(schema, content, f"{above}{name}[].")
        further = inner.get("additionalProperties")
        if isinstance(further, dict):
            named = _resolved(schema, further)
            yield f"{above}{name}.NAME", str(named.get("description", ""))
            yield from _below(schema, named, f"{above}{name}.NAME.")


def _resolved(schema: dict[str, Any], part: Any) -> dict[str, Any]:
    """Return a part of a schema with its reference followed; what stands beside the reference wins."""
    if not isinstance(part, dict):
        return {}
    if "$ref" not in part:
        return part
    found = schema
    for step in part["$ref"].removeprefix("#/").split("/"):
        found = found[step]
    return {**found, **{key: value for key, value in part.items() if key != "$ref"}}
