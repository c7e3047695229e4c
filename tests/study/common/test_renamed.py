"""Former names in configs are refused with the present ones, and the names that are offered are those that exist."""

import json
from pathlib import Path

import pytest
from study.blind_trials.cases import load_study
from study.common.methods import METHODS
from study.common.renamed import RENAMED_KEYS, RENAMED_METHODS, renamed_faults

from scalar.data.io.plain_yaml import load_yaml
from scalar.errors import InvalidInput

ROOT = Path(__file__).parents[3]
SCHEMA = json.loads((ROOT / "workflow/schemas/config.schema.json").read_text(encoding="utf-8"))


@pytest.mark.parametrize("old", RENAMED_KEYS)
def test_a_former_key_is_answered_with_the_present_one(old):
    """At any depth of the config, the message has the place of the former key and its present name."""
    (message,) = renamed_faults({"studies": [{old: 1}]})
    assert message.startswith(f"studies[0].{old}: ") and f"{RENAMED_KEYS[old]!r}" in message


def test_a_former_method_is_answered_with_a_method_that_exists():
    """Every former name of a method leads to one of today's."""
    for old, new in RENAMED_METHODS.items():
        assert new in METHODS
        (message,) = renamed_faults({"methods": ["proposed", old]})
        assert message.startswith("methods[1]: ") and repr(new) in message


def test_the_configs_of_the_repository_hold_no_former_name():
    """No config of the repository is refused for a former name."""
    for path in (ROOT / "configs").glob("*.yaml"):
        assert renamed_faults(load_yaml(path)) == [], path.name


def test_a_config_may_name_every_method_and_no_other():
    """The schema of the workflow's config lists the methods that the code has."""
    assert set(SCHEMA["$defs"]["methods"]["items"]["enum"]) == set(METHODS)


def test_blind_trials_with_a_former_key_are_refused_by_name(tmp_path):
    """A config with the former key `cells` is refused, and the message names it."""
    text = (ROOT / "configs/blind_trials_smoke.yaml").read_text(encoding="utf-8")
    path = tmp_path / "trials.yaml"
    path.write_text(text.replace("\nworkcells:", "\ncells:"), encoding="utf-8")
    with pytest.raises(InvalidInput, match=r"'cells' is now called 'workcells'"):
        load_study(path)
