"""The schema of the workflow's configuration refuses faults with messages in plain words."""

from pathlib import Path

import pytest
from study.common.schema_faults import schema_faults

from scalar.data.io.plain_yaml import load_yaml

ROOT = Path(__file__).parents[3]
SCHEMA = ROOT / "workflow" / "schemas" / "config.schema.json"


@pytest.mark.parametrize("name", ["paper", "smoke"])
def test_our_configurations_have_no_fault(name):
    """The configurations that the workflow runs pass the checks."""
    assert schema_faults(load_yaml(ROOT / "configs" / f"{name}.yaml"), SCHEMA) == []


def test_every_fault_is_one_line():
    """A text in the place of a number and a misspelt key give two lines, each with its key and what to write."""
    config = load_yaml(ROOT / "configs" / "smoke.yaml")
    lines = schema_faults({**config, "first_seed": "one", "seeds_per_jobb": 2}, SCHEMA)
    assert sorted(line.split(":")[0] for line in lines) == ["first_seed", "seeds_per_jobb"]
    assert (
        "first_seed: not a whole number ('one'); write a whole number at least 0 (the first seed; the others follow it)"
        in lines
    )
    assert any(
        "unknown key; did you mean" in line or "unknown key; the keys here are" in line for line in lines
    )
