"""The guide's way to put an arm of the library on a rail."""

from pathlib import Path

import numpy as np
import pytest

from scalar.data.io.plain_yaml import load_yaml_lines
from scalar.geometry.robot import Robot

ROOT = Path(__file__).parents[2]
ARMS = sorted((ROOT / "scalar/robots/arms").glob("*.yaml"))
TURN, QUARTER = 1.2091996, 1.5707963  # rad, as the guide writes them


@pytest.mark.parametrize("path", ARMS, ids=lambda path: path.stem)
def test_the_rail_moves_the_arm_along_x_of_the_base(path):
    """The flange has the pose that the arm alone has, shifted by the travel, for each first joint that the guide names."""
    content = load_yaml_lines(path)[0]["robot"]
    first, *others = content["joints"]
    upside_down = abs(first["alpha"] - np.pi) < 1e-4
    assert upside_down or first["alpha"] == 0.0
    assert first["theta"] == 0.0
    turned = QUARTER if upside_down else -QUARTER
    rail = {"a": 0.0, "alpha": 0.0, "d": 0.0, "theta": 0.0, "type": "prismatic", "limits": [0, 2]}
    joints = [rail, {**first, "alpha": turned, "theta": turned}, *others]
    base = {"translation": [0, 0, 0], "rotation_vector": [TURN, TURN, TURN]}
    on_rail = Robot.from_mapping({**content, "base": base, "joints": joints})
    q, travel = np.random.default_rng(0).uniform(-1, 1, (4, len(others) + 1)), np.array([0.0, 0.5, 1.0, 2.0])
    expected = Robot.from_mapping(content).flange(q)
    expected[:, 0, 3] += travel
    np.testing.assert_allclose(on_rail.flange(np.column_stack([travel, q])), expected, atol=1e-6)


def test_the_numbers_are_those_of_the_guide():
    """What the test above uses stands in the guide."""
    guide = (ROOT / "docs/own_robot.md").read_text(encoding="utf-8")
    assert f"rotation_vector: [{TURN}, {TURN}, {TURN}]" in guide
    assert f"alpha: -{QUARTER}, d: 0.345, theta: -{QUARTER}" in guide
    assert f"alpha: {QUARTER}, theta: {QUARTER}" in guide
