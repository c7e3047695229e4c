"""No module outside ``scalar/sensors`` names a kind of sensor, except the simulator, which is independent of the estimator."""

import ast
from pathlib import Path

import pytest

from scalar.data.sensor_formats import sensor_formats

ROOT = Path(__file__).parents[2]
CLASSES = {"LineLaser", "Probe", "Tracker", "TrackerFrames"}
MODULES = {
    "line_laser",
    "probe",
    "tracker",
    "tracker_frames",
    "tracker_noise",
    "tracker_rows",
    "tracker_start",
}
MAKE_DATA = {
    ROOT / "workflow/study/sensitivity/datasets.py",
    *(
        path
        for study in ("tracked_trials", "real_arm_trials", "spoiled_setups", "coverage")
        for path in (ROOT / "workflow/study" / study).glob("*.py")
    ),
}
"""Simulate datasets of kinds that they choose, as the simulator does."""


def kinds_named(source: str) -> list[str]:
    """Return the places in a module's source that name a kind of sensor: by its name as text, its class or its module."""
    found = []
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Constant) and node.value in sensor_formats():
            found.append(f"{node.lineno}: {node.value!r}")
        elif isinstance(node, ast.Name) and node.id in CLASSES:
            found.append(f"{node.lineno}: {node.id}")
        elif isinstance(node, ast.ImportFrom) and (node.module or "").startswith("scalar.sensors"):
            names = {*(node.module or "").split("."), *(alias.name for alias in node.names)}
            found += [f"{node.lineno}: {name}" for name in sorted(names & (CLASSES | MODULES))]
    return found


def test_no_module_outside_sensors_names_a_kind():
    """Neither the estimator nor the studies name a kind of sensor; they use the capabilities of the protocol."""
    modules = [*ROOT.glob("scalar/**/*.py"), *ROOT.glob("workflow/**/*.py")]
    others = [
        m
        for m in modules
        if m not in MAKE_DATA and not {"sensors", "simulation"} & set(m.relative_to(ROOT).parts)
    ]
    assert len(others) > 50
    named = {str(m.relative_to(ROOT)): kinds_named(m.read_text(encoding="utf-8")) for m in others}
    assert {path: lines for path, lines in named.items() if lines} == {}


@pytest.mark.parametrize(
    "source",
    [
        "dataset.sensor.kind == 'line-laser'",
        "isinstance(m, LineLaser)",
        "from scalar.sensors.tracker_frames import TrackerFrames",
        "from scalar.sensors import probe",
    ],
)
def test_naming_a_kind_is_noticed(source):
    """The test above finds a kind that is named as text, as a class or as a module."""
    assert kinds_named(source)
