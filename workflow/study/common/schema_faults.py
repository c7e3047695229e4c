"""Check a configuration against its JSON schema: a line for each fault names the key, what was found, and what is wanted."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from scalar.data.io.plain_yaml import join_path
from scalar.data.schema_words import in_plain_words
from scalar.data.strict_schema import strict_validator
from scalar.errors import Fault, InvalidInput


def schema_faults(config: Any, schema: Path) -> list[str]:
    """Return a line for every fault that a JSON schema finds in a configuration; an empty list if there is none."""
    return [f"{place or 'configuration'}: {message}" for place, message in _faults(config, schema)]


def refuse_by_schema(content: Any, schema: Path, file: str) -> None:
    """Refuse the content of a file that does not fit a JSON schema.

    Raises:
        InvalidInput: With every fault found; a misspelt key is named.
    """
    faults = [Fault(file, message, column=place or None) for place, message in _faults(content, schema)]
    if faults:
        raise InvalidInput(faults)


def _faults(content: Any, schema: Path) -> list[tuple[str, str]]:
    """Return the place and the message of every fault."""
    validator = strict_validator(json.loads(schema.read_text(encoding="utf-8")))
    errors = validator.iter_errors(content)
    return [(join_path(path), message) for error in errors for path, message in in_plain_words(error)]
