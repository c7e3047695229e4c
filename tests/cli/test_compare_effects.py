"""``scalar compare``: what it says and writes of effects that the calibrations contain."""

import json
from dataclasses import replace

import numpy as np
import pytest

from scalar.effects.joint_backlash import JointBacklash
from scalar.effects.joint_compliance import JointCompliance
from scalar.effects.joint_harmonic import JointHarmonic
from scalar.estimation.result import load_calibration
from tests.cli.comparing import save_calibrations, save_with, softer
from tests.cli.running import run


@pytest.fixture
def folder(tmp_path):
    """Return a folder with calibrations of one arm and of two others."""
    return save_calibrations(tmp_path)


def test_what_was_compared_is_listed(folder):
    """The terminal lists the parameters and effects that both estimated, with their numbers, and those of one only; the JSON has their names."""
    gear = JointHarmonic(4, (2,), coefficients=np.array([1e-4, 0.0]))
    play = JointBacklash(2, "moves", coefficients=np.array([1e-4]))
    one = save_with(folder / "one.json", gear, fixed=["a_3"])
    two = save_with(folder / "two.json", gear, play)
    said = run("compare", one, two, "-o", folder / "c.json")
    assert said.exit_code == 0, said.output
    lines = said.output.splitlines()
    assert (
        "compared: 2 parameters of the geometry (alpha_4, theta_3); 1 effect (joint_harmonic_4_2) with 2 coefficients"
        in lines
    )
    assert "in B only: a_3, joint_backlash_2" in lines
    assert not any(line.startswith("in A only") for line in lines)
    content = json.loads((folder / "c.json").read_text(encoding="utf-8"))
    assert set(content["compared"]) == {
        "alpha_4",
        "theta_3",
        *(f"joint_harmonic_4_2.{part}_rad" for part in ("sin", "cos")),
    }
    assert content["only_in"] == {"A": [], "B": ["a_3", "joint_backlash_2.half_width_rad"]}
    assert not set(content["compared"]) & set(content["not_compared"])


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_play_that_grew_is_said_to_have_grown(folder, side):
    """Half the width of play grows by 0.0115 degrees, whichever sign it has in the files."""
    one, two = (
        save_with(folder / name, JointBacklash(2, "moves", coefficients=np.array([side * size])))
        for name, size in (("one.json", 1e-4), ("two.json", 3e-4))
    )
    said = run("compare", one, two).output
    assert "size of half_width_rad +0.011459 +-" in said


def test_different_effects_are_said_first(folder):
    """If one calibration has as an effect what the other has in its geometry, this is said before any change.

    It is not said if both have the same effects.
    """
    gear = JointHarmonic(4, (2,), coefficients=np.array([1e-4, 0.0]))
    other = load_calibration(folder / "b.json")
    replace(other, model=replace(other.model, effects=(gear,))).save(folder / "gear.json")
    said = run("compare", folder / "a.json", folder / "gear.json")
    assert said.exit_code == 0, said.output
    note = said.output.index("A and B were calibrated with different effects")
    assert note < said.output.index("beyond chance")
    same = run("compare", folder / "a.json", folder / "b.json")
    assert "different effects" not in same.output


def test_the_same_effects_in_another_order_are_one_command(folder):
    """Two diagnoses that found the same effects, the strongest of each first, are not called different; one `--effects` serves both."""
    gear = JointHarmonic(4, (2,), coefficients=np.array([1e-4, 0.0]))
    for name, terms in (("one.json", ((2, 2),)), ("two.json", ((2, 2), (2, 3)))):
        sag = JointCompliance(terms, coefficients=np.full(2 * len(terms), 1e-4))
        effects = (gear, sag) if name == "one.json" else (sag, gear)
        save_with(folder / name, *effects, free=False)
    said = run("compare", folder / "one.json", folder / "two.json").output
    assert "A and B contain the same effects with other coefficients" in said
    assert "different effects" not in said and "A by" not in said
    assert "--effects joint_harmonic:4:2,joint_compliance:2" in said


def test_an_effect_of_many_coefficients_is_one_line(folder):
    """For a gear with nine orders, one line of the terminal says by how many mm it changed and whether that is beyond chance.

    The JSON has all eighteen coefficients.
    """
    gears = [JointHarmonic(4, tuple(range(1, 10)), coefficients=np.full(18, size)) for size in (1e-4, 3e-4)]
    one, two = (
        save_with(folder / name, gear) for name, gear in zip(("one.json", "two.json"), gears, strict=True)
    )
    said = run("compare", one, two, "-o", folder / "c.json").output
    (line,) = [
        line for line in said.splitlines() if gears[1].title in line and "moves predicted positions" in line
    ]
    assert "18 coefficients" in line and "sin" not in said and "p < " in line
    content = json.loads((folder / "c.json").read_text(encoding="utf-8"))
    (change,) = content["changes"]
    assert len(change["parameters"]) == 18
    assert f"by {change['moves_positions']['rms_mm']:.3f} mm RMS" in line
    alone = run("compare", folder / "a.json", two).output
    (line,) = [
        line for line in alone.splitlines() if line.startswith("not compared") and "joint_harmonic" in line
    ]
    assert line.count("joint_harmonic") == 1


def test_positions_that_differ_beyond_chance_stand_in_the_headline(folder):
    """If none of the common coefficients changed, but positions did beyond chance, the headline does not say that nothing changed."""
    one = softer(folder / "one.json", ((2, 2),), 1e-4)
    two = softer(folder / "two.json", ((2, 2), (2, 3), (3, 3)), 5e-4)
    said = run("compare", one, two, "-o", folder / "c.json").output
    assert "no change of the arm" not in said
    assert "beyond chance (" in said and "though no parameter that both calibrations have has changed" in said
    assert "A joint_compliance:2; B joint_compliance:2:3; " in said
    assert "scalar calibrate ... --effects joint_compliance:2:3\n" in said
    content = json.loads((folder / "c.json").read_text(encoding="utf-8"))
    assert content["positions_differ"]["beyond_chance"] is True


def test_an_effect_in_other_coefficients_is_compared_by_positions(folder):
    """If a joint's sag has no coefficient in common in A and B, the positions that result are compared."""
    one = softer(folder / "one.json", ((2, 2),), 1e-4)
    two = softer(folder / "two.json", ((2, 2), (2, 3)), 5e-4)
    said = run("compare", one, two, "-o", folder / "c.json").output
    assert "joint_compliance: A and B describe it by different coefficients" in said
    assert "the arm changed:" not in said
    content = json.loads((folder / "c.json").read_text(encoding="utf-8"))
    (entry,) = content["compared_by_positions"]
    assert entry["beyond_chance"] is True and entry["rms_mm"] > 10 * entry["by_chance_rms_mm"]
    assert not [name for name in content["not_compared"] if name.startswith("joint_compliance")]


def test_equal_sags_in_other_coefficients_are_no_change(folder):
    """If B has one more coefficient, which is zero, the two sags are the same, and the difference is no more than chance."""
    one = softer(folder / "one.json", ((2, 2),), 1e-4)
    two = softer(folder / "two.json", ((2, 2), (2, 3)), [1e-4, 1e-4, 0.0, 0.0])
    said = run("compare", one, two).output
    assert "no more than chance explains" in said
    assert "no change of the arm beyond chance in what was compared" in said


def test_effects_that_were_taken_over_are_not_advised_again(folder):
    """If B has the effects of A, fixed by --effects-from, the advice is to free them in both."""
    one = softer(folder / "one.json", ((2, 2),), 1e-4)
    taken = {"effects_from": {"held": ["joint_compliance"], "not_taken": {}}}
    two = softer(folder / "two.json", ((2, 2),), 5e-4, free=False, misfit=28.0, misfit_p_value=0.0, **taken)
    said = run("compare", one, two).output
    assert "beyond chance (" in said and "--effects joint_compliance:2\n" in said
    assert "--effects-from" not in said
