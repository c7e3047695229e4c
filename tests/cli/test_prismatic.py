"""An arm on a rail through the command line: travels in metres or millimetres, what is offered for them, and what is refused."""

import re

import numpy as np
import pandas as pd
import pytest

from scalar.data.dataset import read_dataset
from scalar.effects import registry
from scalar.effects.command_line import parse_effects
from scalar.errors import InvalidInput
from scalar.estimation.result import Calibration
from tests.cli.correcting import run
from tests.rail_and_arm import RailAndArm, poses
from tests.small_datasets import edit_cell


@pytest.fixture
def folder(tmp_path):
    """Return a dataset folder of 30 poses."""
    rng = np.random.default_rng(4)
    RailAndArm.drawn(rng).dataset(poses(30, rng), 1e-5, rng).write(tmp_path / "d")
    return tmp_path / "d"


def test_a_rail_is_read_and_named(folder):
    """`validate` says which joint slides, and the dataset reads back as it was written."""
    status, said = run("validate", folder)
    assert status == 0 and "7 joints (joint 1 slides)" in said
    assert read_dataset(folder).robot.prismatic == (0,)


def test_travels_in_millimetres_are_suspect(folder):
    """A travel far beyond the limits, and limits in millimetres, are refused with a remedy."""
    edit_cell(folder, "poses.csv", 5, "q1", "812.5")
    status, said = run("validate", folder)
    assert status == 2 and "row 5, column q1" in said and "millimetres" in said
    text = (folder / "dataset.yaml").read_text(encoding="utf-8")
    (folder / "dataset.yaml").write_text(text.replace("1.6", "1600.0"), encoding="utf-8")
    assert "robot.joints[0].limits: suspect: a travel of 1600 m" in run("validate", folder)[1]


def test_prediction_in_degrees_and_millimetres(folder, tmp_path):
    """With `--units deg,mm` the travel is in mm; a column may state its unit, which the output then has too, and degrees of a travel are refused."""
    data = read_dataset(folder)
    Calibration.nominal(data).save(tmp_path / "c.json")
    names = [f"q{i + 1}" for i in range(7)]
    q = pd.DataFrame(data.q[:5], columns=names)
    q.insert(0, "pose", range(5))
    q.to_csv(tmp_path / "si.csv", index=False)
    other = q * np.r_[1, 1e3, np.full(6, 180 / np.pi)]
    other["pose"] = range(5)
    other.to_csv(tmp_path / "units.csv", index=False)
    spelt = other.rename(columns={"q1": "q1_mm", **{n: f"{n}_deg" for n in names[1:]}})
    spelt.to_csv(tmp_path / "spelt.csv", index=False)
    found = []
    for table, options in (("si", []), ("units", ["--units", "deg,mm"]), ("spelt", [])):
        status, said = run(
            "predict", tmp_path / "c.json", tmp_path / f"{table}.csv", *options, "-o", tmp_path / "o.csv"
        )
        assert status == 0, said
        frame = pd.read_csv(tmp_path / "o.csv").to_numpy()[:, 1:]
        found.append(frame * np.r_[1e-3, 1e-3, 1e-3, np.full(3, np.pi / 180)] if table != "si" else frame)
    np.testing.assert_allclose(found[1], found[0], atol=1e-9)
    np.testing.assert_allclose(found[2], found[0], atol=1e-9)
    spelt.rename(columns={"q1_mm": "q1_deg"}).to_csv(tmp_path / "wrong.csv", index=False)
    assert run("predict", tmp_path / "c.json", tmp_path / "wrong.csv", "-o", tmp_path / "x.csv")[0] == 2


def test_effects_fit_the_kind_of_joint(folder):
    """A travel has a scale error, backlash and lag; what gears, wrists and weights do is offered for joints that turn alone."""
    data = read_dataset(folder)
    of_rail, of_turn = (
        {
            effect.name
            for kind in registry.known().values()
            for effect in kind.candidates(data)
            if joint
            in (effect.target.get("joint"), effect.target.get("source"), *effect.target.get("joints", []))
        }
        for joint in (1, 2)
    )
    assert of_rail == {"joint_scale", "joint_backlash", "pose_lag"}
    assert of_turn >= of_rail | {"joint_harmonic", "joint_coupling", "joint_compliance"}
    assert parse_effects("joint_scale:1", data)[0].coefficient_units == ["m/m"]
    assert parse_effects("joint_scale:2", data)[0].coefficient_units == ["rad/rad"]
    for wrong in ("joint_harmonic:1", "joint_coupling:1:2", "joint_coupling:2:1", "joint_compliance:1"):
        with pytest.raises(InvalidInput, match="joint 1 slides"):
            parse_effects(wrong, data)


def test_a_table_of_joints_states_what_slides(folder, tmp_path):
    """The exported table has a column that says which joints slide, and `init --dh` reads such a column, limits in millimetres included."""
    Calibration.nominal(read_dataset(folder)).save(tmp_path / "c.json")
    assert run("export", tmp_path / "c.json", "-o", tmp_path / "dh.csv")[0] == 0
    assert pd.read_csv(tmp_path / "dh.csv")["type"].tolist() == ["prismatic", *["revolute"] * 6]
    table = "a_mm,alpha_deg,d_mm,theta_deg,type,lower_mm,upper_mm,lower_deg,upper_deg\n"
    table += "0,90,10,0,prismatic,-200,800,,\n400,0,0,0,revolute,,,-90,90\n200,0,0,0,revolute,,,,\n"
    (tmp_path / "t.csv").write_text(table, encoding="utf-8")
    arguments = (
        "init",
        tmp_path / "new",
        "--dh",
        tmp_path / "t.csv",
        "--convention",
        "modified-dh",
        "--sensor",
        "tracker",
    )
    status, said = run(*arguments)
    assert status == 0, said
    text = (tmp_path / "new" / "dataset.yaml").read_text(encoding="utf-8")
    assert "-200 to 800 mm" in text and "-90 to 90 degrees" in text and 'type: "prismatic"' in text


def test_near_a_singularity_the_rail_is_not_named_for_its_unit(folder, tmp_path):
    """The rail has the largest number, 45 of its millimetres, but a joint that turns by 12 degrees moves the arm further and is named."""
    Calibration.nominal(read_dataset(folder)).save(tmp_path / "c.json")
    q = pd.DataFrame([[0.3, 0.2, 0.3, 1.2, 0.4, 0.001, 0.1]], columns=[f"q{i + 1}" for i in range(7)])
    q.insert(0, "pose", 1)
    q.to_csv(tmp_path / "targets.csv", index=False)
    status, said = run("correct", tmp_path / "c.json", tmp_path / "targets.csv", "-o", tmp_path / "o.csv")
    assert status == 0 and "near a singularity" in said, said
    assert re.search(r"joint [2-7] moves by up to 1\d deg", said), said
