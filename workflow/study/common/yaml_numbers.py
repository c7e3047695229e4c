"""Numbers that Snakemake's own YAML reader takes for text."""

from __future__ import annotations

from typing import Any

from scalar.data.io.plain_yaml import resolve


def with_numbers(value: Any) -> Any:
    """Return a config in which ``1e-4`` is a number, as in YAML 1.2; Snakemake reads YAML 1.1, in which only ``1.0e-4`` is one."""
    if isinstance(value, dict):
        return {key: with_numbers(item) for key, item in value.items()}
    if isinstance(value, list):
        return [with_numbers(item) for item in value]
    number = resolve(value) if isinstance(value, str) else value
    return number if isinstance(number, float) else value
