"""Plain messages for the errors of a JSON schema: which key is at fault, what was found there, and what to write."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from jsonschema.exceptions import ValidationError

from scalar.data.located_table import MAX_SHOWN, did_you_mean, shorten
from scalar.errors import printable

KeyPath = tuple[str | int, ...]

_KINDS = {
    "number": "a number",
    "integer": "a whole number",
    "array": "a list",
    "object": "a mapping",
    "string": "text",
    "boolean": "true or false",
    "null": "null",
}
_FEW = 3  # up to this length a list is a vector or a pair, whose length is fixed


def in_plain_words(error: ValidationError) -> list[tuple[KeyPath, str]]:
    """Return the faults that a schema error stands for: the place of each, and a message that says what to write instead."""
    path: KeyPath = tuple(error.absolute_path)
    value: Any = error.instance
    expected: Any = error.validator_value
    schema: Any = error.schema
    match error.validator:
        case "additionalProperties":
            known = list(schema["properties"])
            unknown = [key for key in value if key not in known][:MAX_SHOWN]
            return [((*path, key), _unknown_key(key, known, value)) for key in unknown]
        case "required":
            missing = [
                key for key in expected if key not in value and f"{key!r} is a required" in error.message
            ]
            described = schema.get("properties", {})
            return [
                ((*path, key), f"missing; add it: {described.get(key, {}).get('description', key)}")
                for key in missing
            ]
        case "enum":
            known = [str(choice) for choice in expected]
            hint = did_you_mean(str(value), known)
            return [(path, f"unknown ({shorten(value)}); {hint}write one of {', '.join(_choices(known))}")]
        case "const":
            return [(path, f"{shorten(value)} cannot be read by this version; write {expected}")]
        case "anyOf" | "oneOf" if error.context:
            return _of_alternatives(error.context, path, value, schema)
        case _:
            return [(path, f"{_found(error)}; write {wanted(schema)}")]


def wanted(schema: Mapping[str, Any]) -> str:
    """Return what a schema asks for: a number with its limits and meaning; of anything else the description, or else the type."""
    description = str(schema.get("description", ""))
    is_number = schema.get("type") in ("number", "integer")
    if description and not is_number:
        return description
    if "enum" in schema:
        return "one of " + ", ".join(map(str, schema["enum"]))
    for key in ("anyOf", "oneOf"):
        if key in schema:
            return ", or ".join(wanted(choice) for choice in schema[key])
    kinds = _kinds(schema.get("type", []))
    text = " or ".join(_KINDS.get(kind, kind) for kind in kinds) or "another value"
    least, most = schema.get("minItems"), schema.get("maxItems")
    if least is not None and least == most:
        text = f"a list of {least}"
    elif least is not None:
        text += f" of at least {least}"
    limits = [
        f"{words} {schema[key]}"
        for key, words in (
            ("minimum", "at least"),
            ("exclusiveMinimum", "greater than"),
            ("maximum", "at most"),
            ("exclusiveMaximum", "less than"),
        )
        if key in schema
    ]
    if "pattern" in schema:
        limits.append(f"that matches {schema['pattern']}")
    text = " ".join([text, " and ".join(limits)]).strip()
    return f"{text} ({description})" if description else text


def _choices(known: Sequence[str]) -> list[str]:
    """Return the values to choose from, as a message shows them: signs in quotes, and a tab by its escape."""
    shown = [
        choice if any(map(str.isalnum, choice)) and not choice.startswith("\\") else f"'{printable(choice)}'"
        for choice in known
    ]
    return list(dict.fromkeys(shown))


def _unknown_key(key: str, known: Sequence[str], given: Mapping[str, Any]) -> str:
    hint = did_you_mean(key, [k for k in known if k not in given])
    return f"unknown key; {hint}the keys here are {', '.join(known)}"


def _found(error: ValidationError) -> str:
    """Return the value that was found, and why it is refused."""
    value: Any = error.instance
    expected: Any = error.validator_value
    match error.validator:
        case "type":
            return _not_of_kind(value, _kinds(expected))
        case "exclusiveMinimum":
            return f"{value} is not greater than {expected}"
        case "exclusiveMaximum":
            return f"{value} is not less than {expected}"
        case "minimum":
            return f"{value} is less than {expected}"
        case "maximum":
            return f"{value} is greater than {expected}"
        case "maxItems" if expected > _FEW:
            return f"{len(value)} entries, and at most {expected} are read"
        case "minItems" | "maxItems":
            return f"{len(value)} entries where {expected} are needed"
        case "uniqueItems":
            return "an entry stands twice"
        case "minLength" | "minProperties":
            return "empty"
        case _:
            return f"{shorten(value)} does not fit"


def _of_alternatives(
    errors: Sequence[ValidationError], path: KeyPath, value: Any, schema: Mapping[str, Any]
) -> list[tuple[KeyPath, str]]:
    """Return the faults of a value that none of several alternative schemas accepts: those against the schema of its type, if there is one."""
    of_its_kind = [
        error for error in errors if error.validator != "type" or len(error.absolute_path) > len(path)
    ]
    if of_its_kind:
        return [fault for error in of_its_kind for fault in in_plain_words(error)]
    kinds = _kinds(list(dict.fromkeys(kind for error in errors for kind in _kinds(error.validator_value))))
    return [(path, f"{_not_of_kind(value, kinds)}; write {wanted(schema)}")]


def _kinds(expected: Any) -> list[str]:
    kinds = [expected] if isinstance(expected, str) else list(expected)
    return [kind for kind in kinds if kind != "null"] or kinds


def _not_of_kind(value: Any, kinds: Sequence[str]) -> str:
    if value is None:
        return "empty"
    point = "" if "integer" not in kinds or not isinstance(value, float) else ", which has a decimal point"
    return f"not {' or '.join(_KINDS.get(kind, kind) for kind in kinds)} ({shorten(value)}{point})"
