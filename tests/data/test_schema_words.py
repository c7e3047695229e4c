"""Errors of a schema become plain messages: the key, what was found, and what to write."""

from typing import Any

import pytest

from scalar.data.schema_words import in_plain_words
from scalar.data.strict_schema import strict_validator

SCHEMA = {
    "type": "object",
    "additionalProperties": False,
    "required": ["poses"],
    "properties": {
        "poses": {"type": "integer", "minimum": 1},
        "share": {"type": "number", "exclusiveMinimum": 0, "maximum": 1},
        "size_m": {"type": "array", "items": {"type": "number"}, "minItems": 2, "maxItems": 2},
        "order": {"enum": ["shuffled", "by_plane"]},
        "seeds": {
            "type": "array",
            "items": {"type": "integer"},
            "uniqueItems": True,
            "description": "seeds, each once",
        },
        "noise": {"anyOf": [{"type": "number", "minimum": 0}, {"type": "null"}]},
        "name": {"type": "string", "pattern": "^[a-z]+$"},
    },
}


def said(**changes: Any) -> list[str]:
    """Return the messages about a mapping that is valid except for the changes."""
    errors = strict_validator(SCHEMA).iter_errors({"poses": 5} | changes)
    return [
        f"{'.'.join(map(str, path))}: {message}"
        for error in errors
        for path, message in in_plain_words(error)
    ]


def test_a_valid_mapping_gives_no_message():
    """Numbers may be at their limits, and null may stand where it is allowed."""
    assert said(share=1.0, size_m=[1, 2], order="shuffled", seeds=[1, 2], noise=None, name="a") == []


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"poses": 5.0}, "poses: not a whole number (5.0, which has a decimal point); write a whole number at least 1"),
        ({"poses": 0}, "poses: 0 is less than 1; write a whole number at least 1"),
        ({"poses": None}, "poses: empty; write a whole number at least 1"),
        ({"share": 0}, "share: 0 is not greater than 0; write a number greater than 0 and at most 1"),
        ({"share": 2}, "share: 2 is greater than 1; write a number greater than 0 and at most 1"),
        ({"size_m": [1]}, "size_m: 1 entries where 2 are needed; write a list of 2"),
        ({"order": "by_plan"}, "order: unknown ('by_plan'); did you mean 'by_plane'? write one of shuffled, by_plane"),
        ({"seeds": [1, 1]}, "seeds: an entry stands twice; write seeds, each once"),
        ({"noise": "much"}, "noise: not a number ('much'); write a number at least 0, or null"),
        ({"noise": -1}, "noise: -1 is less than 0; write a number at least 0"),
        ({"name": "A1"}, "name: 'A1' does not fit; write text that matches ^[a-z]+$"),
    ],
)  # fmt: skip
def test_a_fault_gives_a_plain_message(change, message):
    """One line says where the fault is, what was found and what to write."""
    assert said(**change) == [message]


def test_a_key_that_is_missing_or_misspelt_is_named():
    """A missing key is named; for a misspelt one, the most similar known key is suggested."""
    errors = strict_validator(SCHEMA).iter_errors({"pose": 1})
    lines = [f"{path[-1]}: {message}" for error in errors for path, message in in_plain_words(error)]
    assert any(line.startswith("poses: missing; add it") for line in lines)
    assert any(line.startswith("pose: unknown key; did you mean 'poses'?") for line in lines)
