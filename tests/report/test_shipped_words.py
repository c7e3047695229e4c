"""What is said where regions of the joint space are held out."""

from types import SimpleNamespace
from typing import Any

import numpy as np

from scalar.report.shipped_words import shipped_sentences


def said(*, without_effects: bool) -> str:
    """Return the sentences on a fit whose effects leave 0.6 mm in four held-out regions, where the model without them leaves 0.25 mm."""
    errors = [SimpleNamespace(rms=rms, block=np.arange(4)) for rms in (2.5e-4, 6e-4)]
    choice = SimpleNamespace(
        left_out=(), added=(), error_with_all=1e-4, error_as_shipped=1e-4, error_measured=1e-4
    )
    shipped = SimpleNamespace(
        regions=tuple(errors),
        without_effects=without_effects,
        decided_by="regions" if without_effects else "only_one",
        choice=choice,
        disagreement=None,
        unconfirmed=(),
    )
    diagnosis: Any = SimpleNamespace(shipped=shipped, outer=None, halves=None, findings=())
    return " ".join(shipped_sentences(diagnosis))


def test_effects_that_do_not_extrapolate_are_said_to_be_findings_only():
    """The sentence states both errors, and that whole regions were held out."""
    text = said(without_effects=True)
    assert (
        "regions of the joint space that are held out as a whole are predicted worse (0.600 mm RMS, 0.250 mm without)"
        in text
    )
    assert "findings only" in text


def test_what_held_out_regions_show_is_said():
    """The sentence states the number of regions, and that nothing is known farther away."""
    text = said(without_effects=False)
    assert (
        "each of 4 regions" in text and "0.600 mm RMS with the effects" in text and "0.250 mm without" in text
    )
    assert "nothing is known of poses farther away" in text
