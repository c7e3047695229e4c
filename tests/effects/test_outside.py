"""An effect that is defined outside the package is found, drawn, saved and applied as the package's own are."""

import json
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from scalar.data.dataset_writer import write_dataset
from scalar.effects import registry
from scalar.errors import InvalidInput
from tests.cli.running import run
from tests.effects.injected import Flaws, make_cell, on_joint
from tests.kinematics import joint_names

FILE = Path(__file__).parent / "outside" / "hose_twist.py"
JOINT, TWIST = 4, 8e-4  # rad: three times what a gear errs by


@pytest.fixture(autouse=True)
def nothing_loaded(monkeypatch):
    """Let every test begin as a new process does: no file of a user's has been loaded."""
    monkeypatch.setattr(registry, "_OF_USERS", {})
    monkeypatch.setattr(registry, "_asked", False)


@pytest.fixture(scope="module")
def cell():
    """Return a workcell whose joint 4 the hose twists, by this test's own formula."""
    twist = on_joint(JOINT, lambda at: TWIST * np.cos(2 * at.q[:, JOINT - 1]) * np.sin(at.q[:, JOINT]))
    return make_cell(Flaws(joints=twist), seed=2, poses_per_plane=40, points_per_scan=12)


@pytest.fixture(scope="module")
def diagnosed(cell, tmp_path_factory):
    """Return the folder of a diagnosis that was told of the file, made by the command line."""
    folder = tmp_path_factory.mktemp("outside")
    tables = cell.scene.tables() | {
        "poses": cell.dataset.poses,
        "scans": pd.DataFrame(
            {
                "pose": np.repeat(cell.dataset.pose_ids, np.diff(cell.dataset.starts)),
                "x": cell.dataset.points[:, 0],
                "z": cell.dataset.points[:, 1],
            }
        ),
    }
    write_dataset(folder / "dataset", mapping=cell.scene.mapping(), **tables)
    with (
        pytest.MonkeyPatch.context() as patch
    ):  # what the command loads is forgotten: later tests in this process know nothing of it
        patch.setattr(registry, "_OF_USERS", {})
        patch.setattr(registry, "_asked", False)
        result = run(
            "diagnose", folder / "dataset", "-o", folder / "out", "--quick", "--effects-module", FILE
        )
    assert result.exit_code == 0, result.output
    at = cell.truth_poses(50, np.random.default_rng(3))[0]
    at[["pose", *joint_names(6)]].to_csv(folder / "joints.csv", index=False)
    (folder / "said.txt").write_text(result.output)
    return folder


def test_an_effect_from_outside_is_named_with_its_coefficient(diagnosed):
    """The diagnosis names the effect, its joint and its size within four standard errors, and nothing else."""
    (entry,) = json.loads((diagnosed / "out" / "diagnosis.json").read_text())["effects"]
    assert (entry["name"], entry["target"]) == ("hose_twist", {"joint": JOINT})
    found = entry["coefficients"]["twist_rad"]
    assert abs(found["value"] - TWIST) < 4 * found["std"] + 0.02 * TWIST
    assert "twist by the hose" in (diagnosed / "said.txt").read_text()


def test_an_effect_from_outside_is_reported_with_a_picture(diagnosed):
    """The report describes the effect in its own words, and draws it without and with the effect."""
    page = (diagnosed / "out" / "report.html").read_text()
    card = page.split("<article>")[1].split("</article>")[0]
    assert "Joint 4: twist by the hose" in card
    assert "hose along the forearm twists the joint" in card
    assert "shift that the effect predicts" in card


def test_an_effect_from_outside_is_saved_with_its_module_and_applied(cell, diagnosed):
    """The calibration states the effect's module, and predictions with the effect are nearer to the truth than those without."""
    saved = json.loads((diagnosed / "out" / "after.json").read_text())["effects"]
    assert [(e["name"], e["module"]) for e in saved] == [("hose_twist", "hose_twist")]
    truth, _ = cell.truth_poses(50, np.random.default_rng(3))
    errors = {}
    for which in ("before", "after"):
        out = diagnosed / f"{which}.csv"
        joints, calibration = diagnosed / "joints.csv", diagnosed / "out" / f"{which}.json"
        result = run("predict", calibration, joints, "-o", out, "--effects-module", FILE)
        assert result.exit_code == 0, result.output
        errors[which] = _apart(pd.read_csv(out), truth)
    assert errors["after"] < 0.5 * errors["before"]


def test_a_calibration_whose_module_is_absent_is_refused_by_name(diagnosed, tmp_path):
    """Without the file, prediction ends with status 2 and one line that names calibration, effect, module and option; nothing is written."""
    out = tmp_path / "frames.csv"
    result = run("predict", diagnosed / "out" / "after.json", diagnosed / "joints.csv", "-o", out)
    assert result.exit_code == 2 and not out.exists()
    (line,) = result.stderr.splitlines()
    for word in ("after.json", "'hose_twist'", "absent", "--effects-module"):
        assert word in line


def test_an_installed_package_offers_it_by_an_entry_point(diagnosed, tmp_path, monkeypatch):
    """Where a package with the entry point is installed, the calibration's module is found without an option."""
    (tmp_path / "hose_twist.py").write_text(FILE.read_text())
    info = tmp_path / "hose_twist-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: hose-twist\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text("[scalar.effects]\nhose_twist = hose_twist\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    result = run(
        "predict", diagnosed / "out" / "after.json", diagnosed / "joints.csv", "-o", tmp_path / "out.csv"
    )
    assert result.exit_code == 0, result.output
    sys.modules.pop("hose_twist", None)
    assert len(pd.read_csv(tmp_path / "out.csv")) == 50


FAULTY = {
    "raise RuntimeError('no licence')": "does not run: RuntimeError: no licence",
    "def broken(": "does not run: SyntaxError",
    "x = 1": "defines no effect",
    FILE.read_text().replace("(OneJoint, ", "("): "HoseTwist lacks from_mapping, target, to_mapping",
    FILE.read_text().replace("hose_twist", "joint_scale"): "another effect is called 'joint_scale'",
}


@pytest.mark.parametrize("text", FAULTY)
def test_a_file_that_offers_no_effect_is_refused(text, tmp_path):
    """A file that does not run, defines nothing, or takes another effect's name is refused by its name, with status 2."""
    file = tmp_path / "mine.py"
    file.write_text(text)
    with pytest.raises(InvalidInput) as caught:
        registry.load_file(file)
    assert caught.value.exit_status == 2
    assert "mine.py" in str(caught.value) and FAULTY[text] in str(caught.value)


WRONG_COLUMNS = {
    "np.zeros((len(poses), robot.n_joints))": "(120, 6) and not (120, 6, 1): poses, joints, coefficients",
    "np.full((len(poses), robot.n_joints, 1), np.nan)": "numbers that are not finite",
}


@pytest.mark.parametrize("columns", WRONG_COLUMNS)
def test_columns_of_a_wrong_shape_are_a_fault_of_the_effect(diagnosed, tmp_path, columns):
    """Calibration and diagnosis end with status 2 and one line that names the effect, its method and what is wrong with the columns."""
    file = tmp_path / "mine.py"
    file.write_text(FILE.read_text().replace("return B", f"return {columns}"))
    own = ("-o", tmp_path / "out", "--effects-module", file)
    for command in (("calibrate", "--effects", "hose_twist:4"), ("diagnose", "--quick")):
        result = run(command[0], diagnosed / "dataset", *own, *command[1:])
        assert result.exit_code == 2, result.output
        (line,) = result.stderr.splitlines()
        for words in ("'hose_twist'", "joint_basis", WRONG_COLUMNS[columns]):
            assert words in line


def test_a_file_that_is_missing_is_refused(tmp_path):
    """A file that is not there is refused by its name."""
    with pytest.raises(InvalidInput, match=r"nowhere\.py"):
        registry.load_file(tmp_path / "nowhere.py")


def _apart(table, truth):
    """Return the root mean square distance [m] of two sets of positions after the best rigid motion between them."""
    p, q = table[["x", "y", "z"]].to_numpy(), truth[["x", "y", "z"]].to_numpy()
    p, q = p - p.mean(0), q - q.mean(0)
    U, _, Vt = np.linalg.svd(p.T @ q)
    R = U @ np.diag([1.0, 1.0, np.sign(np.linalg.det(U @ Vt))]) @ Vt
    return float(np.sqrt(np.mean(np.sum((p @ R - q) ** 2, axis=1))))
