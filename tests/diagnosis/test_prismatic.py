"""A diagnosis of an arm on a rail: a wrong pitch of the rail is named, and nothing without it."""

import numpy as np

from scalar.diagnosis import diagnose
from scalar.report.output import write_diagnosis
from tests.rail_and_arm import RailAndArm, poses

PITCH = 3e-4  # m/m


def test_a_wrong_pitch_of_the_rail_is_named_and_reported(tmp_path):
    """Only the scale error of joint 1 is named, in metres per metre, right within its standard errors; the report can be written."""
    rng = np.random.default_rng(7)
    cell = RailAndArm.drawn(rng)
    q = poses(150, rng)
    q_true = q * np.r_[1 + PITCH, np.ones(6)]
    found = diagnose(cell.dataset(q, 5e-5, rng, q_true=q_true))
    (finding,) = found.findings
    assert (finding.effect.name, finding.effect.target) == ("joint_scale", {"joint": 1})
    entry = found.to_mapping()["effects"][0]["coefficients"]["scale_m_per_m"]
    assert abs(entry["value"] - PITCH) < 4 * entry["std"]
    assert entry["std"] < 0.1 * PITCH
    write_diagnosis(found, tmp_path)
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "in proportion to its travel" in page and "travel of joint 1" in page


def test_nothing_is_found_where_nothing_is_wrong():
    """For the same arm without an error of its drives, nothing is named."""
    rng = np.random.default_rng(7)
    cell = RailAndArm.drawn(rng)
    assert diagnose(cell.dataset(poses(150, rng), 5e-5, rng)).verdict == "no_effect"
