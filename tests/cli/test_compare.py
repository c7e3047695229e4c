"""``scalar compare``: what it says and writes, and what it refuses."""

import json
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner

from scalar.cli import cli
from scalar.effects.joint_backlash import JointBacklash
from scalar.effects.joint_compliance import JointCompliance
from scalar.effects.joint_harmonic import JointHarmonic
from scalar.estimation.result import load_calibration
from scalar.geometry.robot import Robot
from tests.calibrated_arms import calibrated
from tests.robot_configs import robot_mapping


def run(*arguments):
    """Run ``scalar`` in this process."""
    return CliRunner().invoke(cli, [str(argument) for argument in arguments])


@pytest.fixture
def folder(tmp_path):
    """Return a folder with two calibrations of one arm, between which a zero changed by a milliradian, and one of another arm."""

    def save(name, robot, **by):
        made = calibrated(Robot.from_mapping(robot_mapping(robot)), np.random.default_rng(1))
        vector = made.model.vector.copy()
        for parameter, step in by.items():
            vector[made.model.names.index(parameter)] += step
        free = ("a_3", "theta_3", "alpha_4", "sensor_x")
        made = replace(made, model=made.model.with_vector(vector), free=free, covariance=np.eye(4) * 1e-10)
        made.save(tmp_path / name)

    save("a.json", "vs060")
    save("b.json", "vs060", theta_3=1e-3)
    save("bent.json", "vs060", sensor_x=1e-3)
    save("puma.json", "puma560")
    save("panda.json", "panda")
    return tmp_path


def test_a_changed_zero_is_said_and_written(folder):
    """The terminal names the joint, the size of its change in degrees and the move.

    The JSON has the same in SI units, and states what was compared.
    """
    result = run("compare", folder / "a.json", folder / "b.json", "-o", folder / "c.json")
    assert result.exit_code == 0, result.output
    assert "1 change beyond chance" in result.output
    assert "joint 3, zero theta_3: +0.0573" in result.output
    content = json.loads((folder / "c.json").read_text(encoding="utf-8"))
    assert content["changed"] is True
    parameter = content["changes"][0]["parameters"]["theta_3"]
    assert parameter["value"] == pytest.approx(1e-3)
    assert parameter["unit"] == "rad"
    assert content["changes"][0]["moves_positions"]["rms_mm"] > 0


def test_a_tool_that_was_bent_is_no_change_of_the_arm_and_is_said(folder):
    """A sensor that moved on the flange leaves the arm unchanged; its distance is stated, with what that means if nobody took it off."""
    result = run("compare", folder / "a.json", folder / "bent.json")
    assert result.exit_code == 0, result.output
    (line,) = [line for line in result.output.splitlines() if "place on the flange differs" in line]
    assert "1.000 +- 0.014 mm" in line and "not of the arm" in line and "bent" in line


def test_a_sensor_that_stayed_in_its_place_is_not_called_bent(folder):
    """Without a shift there is nothing to explain."""
    assert (
        "0.000 +- 0.014 mm: not beyond chance\n"
        in run("compare", folder / "a.json", folder / "b.json").output
    )


def test_what_was_compared_is_listed(folder):
    """The terminal lists the parameters and effects that both estimated, with their numbers, and those of one only; the JSON has their names."""
    gear = JointHarmonic(4, (2,), coefficients=np.array([1e-4, 0.0]))
    play = JointBacklash(2, "moves", coefficients=np.array([1e-4]))
    for name, effects in (("one.json", (gear,)), ("two.json", (gear, play))):
        made = load_calibration(folder / "a.json")
        made = replace(made, model=replace(made.model, effects=effects))
        names = (*made.free, *(own for names in made.model.effect_names for own in names))
        names = tuple(name for name in names if (name, made.model.effects) != ("a_3", (gear,)))  # fixed in A
        replace(made, free=names, covariance=np.eye(len(names)) * 1e-12).save(folder / name)
    said = run("compare", folder / "one.json", folder / "two.json", "-o", folder / "c.json")
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
    for name, size in (("one.json", 1e-4), ("two.json", 3e-4)):
        made = load_calibration(folder / "a.json")
        play = JointBacklash(2, "moves", coefficients=np.array([side * size]))
        made = replace(made, model=replace(made.model, effects=(play,)))
        names = (*made.free, *made.model.effect_names[0])
        replace(made, free=names, covariance=np.eye(len(names)) * 1e-12).save(folder / name)
    said = run("compare", folder / "one.json", folder / "two.json").output
    assert "size of half_width_rad +0.011459 +-" in said


def test_a_user_of_standard_dh_reads_the_rows_of_that_table(folder):
    """The a_3 of modified DH is shown as the length in row 2 of standard DH, and the JSON keeps the names of the model."""
    for name, step in (("a.json", 0.0), ("b.json", 2e-4)):
        made = load_calibration(folder / name)
        model = made.model.with_vector(made.model.vector + step * (np.array(made.model.names) == "a_3"))
        robots = {
            part: replace(getattr(model, part), standard_end=(0.0, 0.0)) for part in ("nominal", "robot")
        }
        replace(made, model=replace(model, **robots)).save(folder / f"standard_{name}")
    written = folder / "c.json"
    result = run("compare", folder / "standard_a.json", folder / "standard_b.json", "-o", written)
    assert "joint 2, length a 2: +0.20" in result.output and "a_3" not in result.output
    assert "a_3" in written.read_text(encoding="utf-8")


def test_calibrations_whose_noise_nobody_stated_are_compared(folder):
    """For a tracker without stated noise, the numbers that would compare the residual with the noise are null."""
    for name in ("a.json", "b.json"):
        content = json.loads((folder / name).read_text(encoding="utf-8"))
        content["summary"] |= {"misfit": 1.0, "misfit_p_value": None}
        (folder / name).write_text(json.dumps(content), encoding="utf-8")
    result = run("compare", folder / "a.json", folder / "b.json")
    assert result.exit_code == 0, result.output
    assert "joint 3, zero theta_3" in result.output


def test_models_that_lack_something_show_no_change_of_the_arm(folder):
    """If the residual is many times the noise, a difference beyond chance is not called a change. The message says what would show one."""
    for name in ("a.json", "b.json"):
        content = json.loads((folder / name).read_text(encoding="utf-8"))
        content["summary"] |= {"misfit": 28.0, "misfit_p_value": 0.0}
        (folder / name).write_text(json.dumps(content), encoding="utf-8")
    result = run("compare", folder / "a.json", folder / "b.json")
    assert result.exit_code == 0, result.output
    assert "the calibrations differ: 1 difference beyond chance" in result.output
    assert (
        "the arm changed" not in result.output
        and "both by scalar calibrate with the same --effects" in result.output
    )


def test_different_effects_are_said_first(folder):
    """If one calibration has as an effect what the other has in its geometry, this is said before any change.

    It is not said if both have the same effects.
    """
    other = load_calibration(folder / "b.json")
    gear = JointHarmonic(4, (2,), coefficients=np.array([1e-4, 0.0]))
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
        made = load_calibration(folder / "a.json")
        sag = JointCompliance(terms, coefficients=np.full(2 * len(terms), 1e-4))
        effects = (gear, sag) if name == "one.json" else (sag, gear)
        replace(made, model=replace(made.model, effects=effects)).save(folder / name)
    said = run("compare", folder / "one.json", folder / "two.json").output
    assert "A and B contain the same effects with other coefficients" in said
    assert "different effects" not in said and "A by" not in said
    assert "--effects joint_harmonic:4:2,joint_compliance:2" in said


def softer(path, terms, size, free=True, **summary):
    """Save a calibration whose joints give way, by terms and a coefficient [rad] that are given, and return its path."""
    made = load_calibration(path.parent / "a.json")
    effect = JointCompliance(terms, coefficients=np.broadcast_to(size, 2 * len(terms)))
    made = replace(made, model=replace(made.model, effects=(effect,)), summary={**made.summary, **summary})
    if free:
        names = (*made.free, *made.model.effect_names[0])
        made = replace(made, free=names, covariance=np.eye(len(names)) * 1e-12)
    made.save(path)
    return path


def test_an_effect_of_many_coefficients_is_one_line(folder):
    """For a gear with nine orders, one line of the terminal says by how many mm it changed and whether that is beyond chance.

    The JSON has all eighteen coefficients.
    """
    made = load_calibration(folder / "a.json")
    for name, size in (("one.json", 1e-4), ("two.json", 3e-4)):
        gear = JointHarmonic(4, tuple(range(1, 10)), coefficients=np.full(18, size))
        one = replace(made, model=replace(made.model, effects=(gear,)))
        names = (*made.free, *one.model.effect_names[0])
        replace(one, free=names, covariance=np.eye(len(names)) * 1e-12).save(folder / name)
    said = run("compare", folder / "one.json", folder / "two.json", "-o", folder / "c.json").output
    (line,) = [
        line for line in said.splitlines() if gear.title in line and "moves predicted positions" in line
    ]
    assert "18 coefficients" in line and "sin" not in said and "p < " in line
    content = json.loads((folder / "c.json").read_text(encoding="utf-8"))
    (change,) = content["changes"]
    assert len(change["parameters"]) == 18
    assert f"by {change['moves_positions']['rms_mm']:.3f} mm RMS" in line
    alone = run("compare", folder / "a.json", folder / "two.json").output
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


def test_the_same_calibration_twice_shows_no_change(folder):
    """Comparing a file with itself, or with a copy, ends with exit status 0; that nothing changed is said, and that both are one calibration."""
    (folder / "copy.json").write_bytes((folder / "a.json").read_bytes())
    for other, same in (("a.json", True), ("copy.json", True), ("b.json", False)):
        result = run("compare", folder / "a.json", folder / other)
        assert result.exit_code == 0
        assert ("no change of the arm beyond chance" in result.output) == same
        assert ("A and B are the same calibration" in result.output) == same


@pytest.mark.parametrize(
    ("other", "words"),
    [("puma.json", "another arm"), ("panda.json", "7 joints"), ("none.json", "no such file")],
)
def test_what_cannot_be_compared_is_refused(other, words, folder):
    """For another arm or a missing file the exit status is 2, with one line, and nothing is written."""
    result = run("compare", folder / "a.json", folder / other, "-o", folder / "c.json")
    assert result.exit_code == 2
    assert words in result.stderr
    assert len(result.stderr.splitlines()) == 1
    assert not (folder / "c.json").exists()


def test_a_calibration_without_standard_errors_is_refused(folder):
    """A calibration that was never fitted has no standard errors by which chance could be judged, and is refused."""
    made = calibrated(Robot.from_mapping(robot_mapping("vs060")), np.random.default_rng(1))
    made.save(folder / "nominal.json")
    result = run("compare", folder / "a.json", folder / "nominal.json")
    assert result.exit_code == 2
    assert "no standard errors" in result.stderr
