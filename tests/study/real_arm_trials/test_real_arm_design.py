"""The design of the real-arm trials: every effect at every size, alone and beside two others, with the columns that it needs."""

from collections import Counter
from itertools import product
from pathlib import Path

import pytest
import yaml
from study.blind_trials.stratified_design import numbers_of
from study.real_arm_trials.design import COLUMNS, INSTRUMENTS, NEEDS, NONE, SIZES, Design, load_real_arm

from scalar.errors import InvalidInput

ROOT = Path(__file__).parents[3]
CONFIG = ROOT / "configs/real_arm_trials.yaml"


@pytest.fixture(scope="module")
def design():
    """Return the committed design."""
    return load_real_arm(CONFIG)


@pytest.fixture(scope="module")
def trials(design):
    """Return all sets, by the instrument."""
    return {
        instrument: [
            design.trial(instrument, k)
            for i, job in design.jobs()
            if i == instrument
            for k in numbers_of(job)
        ]
        for instrument in INSTRUMENTS
    }


def name_of(cause):
    """Return the name of an entry of ``injected`` in the design."""
    return cause.get("kind", cause["effect"])


def test_every_effect_is_injected_at_every_size_alone_and_in_company(design, trials):
    """Each effect of an instrument has as many sets of each size, alone and beside two others, as the design has repetitions."""
    for instrument, sets in trials.items():
        one = design.content["instruments"][instrument]
        counted = Counter((t.effect, t.size, t.company) for t in sets)
        repetitions = one["repetitions"]
        crossed = product(one["effects"], SIZES, (0, 2))
        assert counted == {key: repetitions for key in crossed} | {
            (NONE, NONE, 0): repetitions * one["nulls"]
        }


def test_the_sizes_are_a_third_of_the_natural_one_this_and_three_times(design, trials):
    """The effect that is judged has a size of the design, and the further effects about their natural ones."""
    for instrument, sets in trials.items():
        one = design.content["instruments"][instrument]
        for trial in sets:
            assert len(trial.causes) == (0 if trial.effect == NONE else 1 + trial.company)
            for k, cause in enumerate(trial.causes):
                natural = one["companions" if k else "effects"][name_of(cause)]
                times = cause["size"] / natural
                if k:
                    assert 0.7 <= times <= 1.5
                else:
                    assert times == pytest.approx(
                        {"third": 1 / 3, "natural": 1, "three_times": 3}[trial.size]
                    )


def test_no_two_causes_of_a_set_are_alike(trials):
    """No effect occurs twice, nor in the joint of another one, and a compliance under arm and payload not beside that under the payload alone."""
    for trial in (t for sets in trials.values() for t in sets):
        names = [name_of(cause) for cause in trial.causes]
        if trial.instrument != "rail":
            assert len(set(names)) == len(names)
            joints = [
                cause["target"]["joint"] for cause in trial.causes if "joint" in cause.get("target", {})
            ]
            assert len(set(joints)) == len(joints)
        assert not {"torque_compliance", "payload_deflection"} <= set(names)


def test_sets_record_what_their_effects_need_and_null_sets_record_everything(trials):
    """Without the record an effect could not be proposed; a record must not give an effect away."""
    for trial in (t for sets in trials.values() for t in sets):
        for cause in trial.causes:
            assert NEEDS.get(name_of(cause), set()) <= set(trial.record)
        assert trial.stops or "restarted_warm_up" not in map(name_of, trial.causes)
    nulls = [t for t in trials["tracker"] if t.effect == NONE]
    assert all(set(t.record) == set(COLUMNS) and t.sessions == 2 and t.stops == 2 for t in nulls)
    effects = [t for t in trials["tracker"] if t.effect == "pose_lag"]
    assert len({t.record for t in effects}) > 3  # other columns are there or not


def test_a_set_follows_from_the_seed_its_instrument_and_its_number(design, trials):
    """No two sets share a seed, more repetitions leave the first sets as they are, and another seed of the design gives other sets."""
    every = [t for sets in trials.values() for t in sets]
    assert len({t.seed for t in every}) == len(every)
    one = design.content["instruments"]["rail"]
    longer = {**design.content["instruments"], "rail": {**one, "repetitions": 9}}
    assert Design(design.content | {"instruments": longer}).trial("rail", 3) == trials["rail"][3]
    assert Design(design.content | {"seed": 1}).trial("rail", 3) != trials["rail"][3]


@pytest.mark.parametrize(("key", "value"), [("poses", []), ("seeed", 1), ("instruments", {"probe": {}})])
def test_a_fault_of_the_config_is_refused(key, value, design, tmp_path):
    """The message names the place of the fault."""
    (tmp_path / "design.yaml").write_text(yaml.safe_dump(design.content | {key: value}), "utf-8")
    with pytest.raises(InvalidInput, match=key):
        load_real_arm(tmp_path / "design.yaml")
