"""The committed tables that the paper reads beside ``numbers.json``: names alone, so that the rule that lists the files imports nothing slow."""

TABLES = ("by_scene", "power", "errors", "unknown")
"""Names of those of the blind trials."""
