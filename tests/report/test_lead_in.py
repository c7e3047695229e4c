"""Paragraphs at the head of the report begin in bold with what they are about."""

import pytest

from scalar.report.lead_in import lead_in


@pytest.mark.parametrize(
    ("text", "first"),
    [
        ("Where nothing was measured, expect up to 1.17 mm RMS.", "Where nothing was measured"),
        (
            "When each of 8 regions of the joint space is held out as a whole, its poses",
            "When each of 8 regions of the joint space is held out as a whole",
        ),
        ("Structure without a name is corrected.", ""),
    ],
)
def test_the_first_words_say_what_a_paragraph_is_about(text, first):
    """Nothing of the paragraph is lost, and one that begins otherwise stays as it is."""
    assert lead_in(text) == (first, text[len(first) :])
