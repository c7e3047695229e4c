"""The table of the keys of a mapping for `scalar import`."""

from __future__ import annotations

from pathlib import Path

from scalar.ingest.mapping_keys import keys_of_a_mapping


def write_table(path: Path) -> None:
    """Write a table of every key, where it stands and what it means."""
    rows = "".join(
        f"| `{key}` | {meaning.replace('|', chr(92) + '|')} |\n" for key, meaning in keys_of_a_mapping()
    )
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f"| key | meaning |\n| --- | --- |\n{rows}", encoding="utf-8")
