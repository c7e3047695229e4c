"""Effects and cases have words of the field, each its own, and none that is a name of the code."""

import pytest
from study.blind_trials.score import NOISES
from study.common.effect_words import WORDS, case_words
from study.common.tables import read_table

from scalar.effects.flexible.unattributed import Unattributed
from scalar.effects.registry import known
from tests.study.paper.test_paper import PAPER

CASES = sorted(set(read_table(PAPER / "summaries/blind_trials/errors.csv")["case"]))


def test_every_effect_has_words_of_its_own():
    """No effect of the catalogue, and no noise, is shown by the name of the code, and no two by the same words."""
    names = [*({*known(), *NOISES} - {Unattributed.name})]
    words = [WORDS[name] for name in names]
    assert len(set(words)) == len(words)
    assert not any("_" in text for text in words)


@pytest.mark.parametrize("case", CASES)
def test_no_case_is_shown_by_a_name_of_the_code(case):
    """Each case of the committed trials has words without an underscore, and a variant's begin with those of its effect."""
    words = case_words(case)
    assert "_" not in words and "-" not in words
    name, _, variant = case.partition("-")
    assert variant == "" or name == "unknown" or words.startswith(case_words(name) + ", ")


def test_an_unknown_cause_without_words_is_an_error():
    """A new unknown cause needs words before it is shown."""
    with pytest.raises(KeyError):
        case_words("unknown-no_such_cause")
