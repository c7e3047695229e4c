"""Tables as a controller writes them: columns of other names, and frames of a tool, are recognised or asked about."""

import pandas as pd

from tests.cli.correcting import JOINTS, predicted, run


def test_columns_that_a_controller_calls_otherwise_are_recognised(program):
    """J1 to J6 are asked about one by one; a place in capitals is renamed in one line, with the orientation of its maker."""
    joints = pd.read_csv(program / "targets.csv")
    names = {f"q{i}": f"Joint_{i}" for i in range(1, 7)}
    joints.rename(columns=names).to_csv(program / "joints.csv", index=False)
    for command in ("correct", "predict"):
        status, said = run(
            command, program / "calibration.json", program / "joints.csv", "-o", program / "o.csv"
        )
        assert status == 2 and all(
            f"column {q}: the column is missing; is it '{name}'" in said for q, name in names.items()
        )
    (program / "fanuc.csv").write_text("pose,X,Y,Z,W,P,R\n1,0.1,0.2,0.3,0,0,0\n")
    status, said = run(
        "correct", program / "calibration.json", program / "fanuc.csv", "-o", program / "o.csv"
    )
    assert status == 2 and len(said.splitlines()) == 1
    assert (
        "X, Y, Z of a place are called x, y, z" in said and "W, P, R of a FANUC are roll, pitch, yaw" in said
    )


def test_whose_frames_the_wanted_ones_are_is_said(program, arm_calibration):
    """Frames of a tool on the flange would be taken for the sensor's, off by the distance between the two; joint angles need no such line."""
    predicted(program, "targets.csv")
    (program / "wanted.csv").write_text((program / "frames.csv").read_text())
    rest = pd.read_csv(program / "targets.csv").drop(columns=JOINTS)
    pd.read_csv(program / "wanted.csv").merge(rest, on="pose").to_csv(program / "wanted.csv", index=False)
    status, said = run(
        "correct", program / "calibration.json", program / "wanted.csv", "-o", program / "a.csv"
    )
    place = ", ".join(f"{1e3 * x:.1f}" for x in arm_calibration.model.T_flange_sensor[:3, 3])
    assert status == 0 and f"frames are taken for those of the sensor, which sits at {place} mm" in said, said
    status, said = run(
        "correct", program / "calibration.json", program / "targets.csv", "-o", program / "b.csv"
    )
    assert status == 0 and "frames are taken" not in said
