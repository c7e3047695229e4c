"""What the schema of a configuration refuses, a line a fault: which key, what was found, and what is wanted."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from jsonschema import Draft202012Validator

from scalar.data.io.plain_yaml import join_path
from scalar.data.schema_words import in_our_words


def schema_faults(config: Any, schema: Path) -> list[str]:
    """Return a line for every fault that a JSON schema finds in a configuration; none where it has none."""
    validator = Draft202012Validator(json.loads(schema.read_text(encoding="utf-8")))
    return [
        f"{join_path(path) or 'configuration'}: {message}"
        for error in validator.iter_errors(config)
        for path, message in in_our_words(error)
    ]
