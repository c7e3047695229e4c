"""``scalar import --keys`` prints every key that a mapping may have."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml
from click.testing import CliRunner

from scalar.cli.group import cli

MAPPINGS = sorted((Path(__file__).parents[2] / "configs" / "measured").glob("*.yaml"))


def keys_used(part: Any, above: str = "") -> Iterator[str]:
    """Yield the keys of a mapping with their places; what follows the key ``dataset`` is a dataset.yaml and has keys of its own."""
    if isinstance(part, list):
        for entry in part:
            yield from keys_used(entry, f"{above.removesuffix('.')}[].")
    elif isinstance(part, dict):
        for key, value in part.items():
            yield f"{above}{key}"
            if above or key != "dataset":
                yield from keys_used(value, f"{above}{key}.")


@pytest.mark.parametrize("path", MAPPINGS, ids=lambda path: path.stem)
def test_all_keys_of_the_committed_mappings_are_printed(path):
    """Each key of a mapping in configs/measured is a line of the output; names of the user's choice stand as NAME there."""
    mapping = yaml.safe_load(path.read_text(encoding="utf-8"))
    if not str(mapping.get("format", "")).startswith("scalar-mapping"):
        pytest.skip("no mapping")
    output = CliRunner().invoke(cli, ["import", "--keys"])
    assert output.exit_code == 0
    printed = [line.split(": ")[0] for line in output.output.splitlines()]
    patterns = [re.compile(re.escape(key).replace("NAME", "[^.]+")) for key in printed]
    for key in keys_used(mapping):
        assert any(pattern.fullmatch(key) for pattern in patterns), key
