"""The sentence on errors where nothing was measured."""

import pytest

from scalar.report.unmeasured_words import unmeasured_sentence


def mapping(along: str = "q2", upper: bool = True, chance: float = 0.1, fit: str = "equal_weights") -> dict:
    half = {"along": along, "upper": upper, "poses": 30, "rms_mm": 1.2, "chance_rms_mm": chance}
    entry = {
        "rms_mm": 1.2,
        "halves": 22,
        "median_rms_mm": 0.4,
        "worst_half": half,
        "without_effects_rms_mm": 1.9,
    }
    shipped = {"fit": fit, "expected_error_mm": {"as_shipped_within_joint_limits": 0.8}}
    residual = {"after": {"held_out_rms_mm": 0.2}}
    return {
        "unmeasured": entry,
        "shipped": shipped,
        "effects": [{"name": "joint_scale"}],
        "residual": residual,
    }


@pytest.mark.parametrize(
    ("along", "upper", "words"),
    [
        ("q2", True, "that with the larger values of joint 2"),
        ("q12", False, "that with the smaller values of joint 12"),
        ("x", False, "that with the smaller x of the flange"),
        ("z", True, "that with the larger height z of the flange"),
        ("order", False, "the earlier one"),
        ("order", True, "the later one"),
    ],
)
def test_the_worst_half_is_named(along, upper, words):
    """The sentence begins with the error of the half that is predicted worst, and names this half."""
    text = unmeasured_sentence(mapping(along, upper, fit="before"))
    assert text.startswith("Where nothing was measured, expect up to 1.20 mm RMS. Each of 22 halves")
    assert "the median errs by 0.400 mm" in text
    assert text.endswith(f"and the worst, {words}, by 1.20 mm.")


def test_the_error_without_effects_is_said_if_effects_are_corrected():
    """Both errors stand there, unless after.json has no effects."""
    assert "(without effects the worst by 1.90 mm)" in unmeasured_sentence(mapping())
    assert "without" not in unmeasured_sentence(mapping(fit="before"))


@pytest.mark.parametrize(("chance", "is_said"), [(0.5, False), (1.1, True)])
def test_chance_errors_of_few_poses_are_said_to_be_that(chance, is_said):
    """Where most of the squared error is expected of the other half's chance errors, the sentence says so."""
    text = unmeasured_sentence(mapping(chance=chance))
    assert ("hardly determines" in text) == is_said


@pytest.mark.parametrize(("median", "is_said"), [(3.0, False), (60.0, True)])
def test_halves_that_err_by_many_times_as_much_determine_nothing(median, is_said):
    """Held-out poses err by 0.2 mm; if most halves err by decimetres, no half determines the model, and the sentence says so."""
    said = mapping()
    said["unmeasured"]["median_rms_mm"] = median
    assert ("do not determine the model" in unmeasured_sentence(said)) == is_said


@pytest.mark.parametrize(
    ("limits", "where"),
    [(7.5, "over the whole of the joint limits"), (None, "at poses like those that were measured")],
)
def test_a_larger_error_that_is_stated_elsewhere_is_said_to_be_that(limits, where):
    """The sentence says where the error is expected, and what the worst half errs by."""
    said = mapping(fit="before")
    said["unmeasured"]["rms_mm"] = 7.5
    said["shipped"]["expected_error_mm"]["as_shipped_within_joint_limits"] = limits
    text = unmeasured_sentence(said)
    assert text.startswith(f"Where nothing was measured, expect up to 7.50 mm RMS, as {where}. ")
    assert text.endswith("by 1.20 mm.")


def test_too_few_poses_are_said_to_be_that():
    """Without halves no number is stated."""
    assert "too few" in unmeasured_sentence({"unmeasured": None})
