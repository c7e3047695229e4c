"""The levels to which rules lower the confidence in a name stand on the right sides of what a name needs and of what a sure one has."""

from scalar.diagnosis.naming.most_confidence import NOT_SURE, ONE_OF_TWO
from scalar.diagnosis.settings import DEFAULTS
from scalar.report.noise_card import SURE


def test_one_of_two_causes_has_no_name_and_an_unsure_one_has():
    """With one of two causes the confidence is a half, and a name is doubtful; an unsure name is given, and has to be confirmed."""
    assert ONE_OF_TWO == 0.5 < DEFAULTS.naming.least_confidence < NOT_SURE < SURE
