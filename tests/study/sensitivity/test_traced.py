"""Traced numbers: the value's own result, and a note of every alternative that would have led elsewhere, no other missing."""

import operator
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from study.sensitivity.answers import answer_of, differences
from study.sensitivity.datasets import make_dataset
from study.sensitivity.sets import load_sets
from study.sensitivity.traced import Trace, Traced, counted
from study.sensitivity.traced_estimator import comparing_results, same_content, traced_estimator
from study.sensitivity.variants import traced_settings, variants

from scalar.diagnosis import diagnose
from scalar.diagnosis.settings import DEFAULTS
from scalar.estimation.settings import documentation

ROOT = Path(__file__).parents[3]
NUMBERS = st.floats(0.1, 10.0)
OPERATORS = st.sampled_from([operator.add, operator.sub, operator.mul, operator.truediv, min, max])


def traced(value, **alternatives):
    """Return a traced number and its trace."""
    trace = Trace()
    return Traced(value, alternatives, trace), trace


@given(NUMBERS, NUMBERS, NUMBERS, NUMBERS, OPERATORS, OPERATORS)
def test_a_traced_number_computes_as_a_plain_one_and_notes_alternatives_that_end_elsewhere(
    value, other, a, b, first, second
):
    """For any two operations and a comparison, the outcome is that of plain numbers, and an alternative has diverged if its outcome is another."""

    def outcome(x):
        return second(first(x, a), np.float64(b)) < 5.0

    number, trace = traced(value, other=other)
    assert bool(outcome(number)) == bool(outcome(value))
    if outcome(other) != outcome(value):
        assert trace.diverged == {"other"}


@pytest.mark.parametrize(
    ("ask", "diverging"),
    [
        (lambda x: x > 1.5, {"low"}),
        (lambda x: x > 0.5, set()),
        (lambda x: np.float64(2.5) < x, {"high"}),
        (lambda x: np.array([1.2, 9.0]) < x, {"low"}),
        (lambda x: np.maximum(np.array([7.0, 9.0]), x) * 2.0, set()),
        (lambda x: float(np.maximum(np.array([3.0, 9.0]), x)[0]), {"high"}),
        (lambda x: float(max(x, 3.0)), {"high"}),
        (lambda x: float(x), {"low", "high"}),
        (lambda x: int(x * 0.4), {"high"}),
        (lambda x: np.full(3, x), {"low", "high"}),
        (lambda x: [0, 1, 2, 3, 4, 5][: int(np.ceil(x))], {"low", "high"}),
        (lambda x: x + 1.0, set()),
    ],
)
def test_exactly_those_alternatives_diverge_that_come_out_otherwise(ask, diverging):
    """For a number 2, those of the alternatives 1 and 4 diverge with which a comparison, array, count or conversion gives another result."""
    number, trace = traced(2.0, low=1.0, high=4.0)
    result, plain = ask(number), ask(2.0)
    assert np.array_equal(result if isinstance(result, np.ndarray | list) else plain, plain)
    assert trace.diverged == diverging
    assert trace.used == {"low", "high"}


@pytest.mark.parametrize(
    ("rounds", "diverging"), [(1, set()), (2, set()), (3, {"low"}), (4, {"low"}), (9, {"low", "high"})]
)
def test_a_loop_diverges_only_under_bounds_that_change_its_number_of_rounds(rounds, diverging):
    """With bounds of 4, 2 and 8, a loop that is left in its second round is the same under all, and one that runs out is another under 8."""
    bound, trace = traced(4, low=2, high=8)
    done = 0
    for i in counted(bound):
        done = i + 1
        if done == rounds:
            break
    assert done == min(rounds, 4)
    assert trace.diverged == diverging


def test_a_function_compared_by_its_result_diverges_only_with_another_result():
    """Of 2, 9, 4 and 5, two are below 4.5. Below 4.2 they are the same two, though a comparison diverges; below 8 there are three."""

    def below(values, threshold):
        kept = [float(value) for value in values if float(value) + 0.0 * float(threshold) < float(threshold)]
        return tuple(kept), np.array(len(kept))

    number, trace = traced(4.5, near=4.2, far=8.0)
    assert comparing_results(below, same_content)([2.0, 9.0, 4.0, 5.0], threshold=number) == ((2.0, 4.0), 2)
    assert trace.diverged == {"far"} and trace.used == {"near", "far"}
    assert comparing_results(below, same_content)([2.0, 9.0], 4.5) == ((2.0,), 1)


def test_a_result_that_is_itself_traced_is_computed_for_every_alternative():
    """Twice a traced threshold makes no alternative diverge; a function that returns it returns the plain number, and both alternatives diverge."""
    number, trace = traced(4.5, near=4.2, far=8.0)
    assert comparing_results(lambda x: (2.0 * x,), same_content)(number) == (9.0,)
    assert trace.diverged == {"near", "far"}


def test_plain_ranges_stay_as_they_are():
    """Without a traced bound ``range`` is the built-in, and after the study the modules have their own functions again."""
    from scalar.diagnosis import diagnose as module_of_its_own  # so that the modules are there
    from scalar.diagnosis.held_out import hold_out, repetitions

    before = repetitions.first_of_repetitions
    assert counted(2, 5) == range(2, 5)
    with traced_estimator():
        assert vars(hold_out)["range"] is counted and repetitions.first_of_repetitions is not before
    assert "range" not in vars(hold_out) and repetitions.first_of_repetitions is before
    assert callable(module_of_its_own)


@pytest.fixture(scope="module")
def small_set():
    """Return a small blind set and its true poses."""
    sets = load_sets(ROOT / "configs/sensitivity_smoke.yaml")
    return make_dataset(sets.sets["scale"], sets, ROOT)


@pytest.mark.slow
def test_variants_that_do_not_diverge_give_the_same_answer_when_run(small_set):
    """Of the variants that diverged in no operation, twelve are run: every number is the default's to the last bit.

    Confidences are compared by the side of 0.8 on which they are.
    """
    dataset, truth_poses = small_set
    trace, wanted = Trace(), [v for v in variants() if not v.setting.startswith("confidence.")]
    default = diagnose(dataset).to_mapping()
    with traced_estimator():
        assert diagnose(dataset, settings=traced_settings(wanted, trace)).to_mapping() == default
    assert trace.diverged < trace.used < set(wanted)
    same = [variant for variant in wanted if variant in trace.used - trace.diverged]
    for variant in np.random.default_rng(3).permutation(len(same))[:12]:
        assert diagnose(dataset, settings=same[variant].settings).to_mapping() == default, same[variant]
    loosest = [variant for variant in wanted if variant.setting == "observability.unobservable"]
    answers = [answer_of(diagnose(dataset, settings=v.settings), truth_poses) for v in loosest]
    told = [bool(differences(answer_of(diagnose(dataset), truth_poses), answer)) for answer in answers]
    assert {v for v, is_told in zip(loosest, told, strict=True) if is_told} <= trace.diverged


def test_every_threshold_has_a_variant_on_either_side():
    """Every number is halved and doubled; counts stay whole and above zero, chances and shares below one."""
    documented = documentation(DEFAULTS)
    found = {(v.setting, v.direction): v.value for v in variants()}
    for name, entry in documented.items():
        value, low, high = entry["value"], found.get((name, "halved")), found.get((name, "doubled"))
        assert low is not None or value == 1, name
        assert high is not None and high > value, name
        assert low is None or 0 < low < value, name
        assert type(high) is type(value), name
        if isinstance(value, float) and value < 1.0 and entry["unit"] == "1":
            assert high < 1.0, name
