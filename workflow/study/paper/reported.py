"""The committed tables that the paper reads beside ``numbers.json``: names alone, so that a rule that lists the files imports no statistics."""

TABLES = ("by_scene", "power", "errors", "unknown")
"""Of the blind trials."""
