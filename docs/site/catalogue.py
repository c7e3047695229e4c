"""The workcell in which each effect of the catalogue is shown: how to inject it, and how a command line names it.

One entry for each effect of the registry. Pages and pictures are made from it, and a test simulates every scene.
"""

from __future__ import annotations

import tempfile
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from scalar.data.dataset import Dataset, read_dataset
from scalar.data.io.plain_yaml import load_yaml
from scalar.effects.effect import Effect
from scalar.effects.registry import kind_named

ROOT = Path(__file__).resolve().parents[2]
SCENE = "configs/scenes/injected.yaml"  # the workcell of the pages; what is injected is replaced


@dataclass(frozen=True)
class Shown:
    """An effect as its page shows it.

    Attributes:
        words: The effect as ``scalar calibrate --effects`` takes it; empty if it cannot be given there.
        changes: Top-level keys of the scene that inject it.
        note: A sentence on the injection, if one is needed.
    """

    words: str
    changes: dict[str, Any] = field(default_factory=dict)
    note: str = ""


def _injected(effect: str, **entry: Any) -> dict[str, Any]:
    return {"injected": [{"effect": effect, **entry}]}


CATALOGUE: dict[str, Shown] = {
    "joint_compliance": Shown("joint_compliance", _injected("joint_compliance")),
    "torque_compliance": Shown("torque_compliance", _injected("torque_compliance")),
    "payload_deflection": Shown("payload_deflection", _injected("payload_deflection", size=2.0e-5)),
    "base_compliance": Shown("base_compliance", _injected("base_compliance", size=1.0e-5)),
    "joint_harmonic": Shown(
        "joint_harmonic:4:2", _injected("joint_harmonic", target={"joint": 4, "order": 2}, size=3.0e-4)
    ),
    "joint_ripple": Shown(
        "joint_ripple:2:40", _injected("joint_harmonic", target={"joint": 2, "orders": [40]}, size=3.0e-4)
    ),
    "joint_scale": Shown("joint_scale:3", _injected("joint_scale", target={"joint": 3}, size=1.0e-3)),
    "joint_coupling": Shown(
        "joint_coupling:6:5", _injected("joint_coupling", target={"joint": 6, "source": 5}, size=2.0e-3)
    ),
    "joint_backlash": Shown(
        "joint_backlash:2", _injected("joint_backlash", target={"joint": 2}, size=3.0e-4)
    ),
    "joint_hysteresis": Shown(
        "joint_hysteresis:2",
        {
            **_injected("joint_hysteresis", target={"joint": 2}, size=6.0e-4, travel_rad=0.3),
            "record": ["time"],
        },
        "A diagnosis looks for it only where the order of poses is recorded (`order` or `time`) and no direction of approach, and only by "
        "travels that the moves distinguish from backlash.",
    ),
    "pose_lag": Shown("pose_lag:1", _injected("pose_lag", target={"joint": 1}, size=1.0e-3)),
    "axis_nonparallel": Shown(
        "axis_nonparallel:3", _injected("axis_nonparallel", target={"joint": 3}, size=2.0e-3)
    ),
    "thermal_drift": Shown("thermal_drift:temperature", _injected("thermal_drift", size=5.0e-4)),
    "restarted_warm_up": Shown(
        "restarted_warm_up:time",
        {
            **_injected("restarted_warm_up", size=1.0e-3, constant_s=120.0),
            "stops": {"count": 2, "duration_s": 3600},
        },
        "A diagnosis looks for it only where the record has stops: gaps in the time, or sessions where no time is recorded.",
    ),
    "target_drift": Shown(
        "target_drift:time",
        _injected("target_drift", size=5.0e-4),
        "A diagnosis looks for it where the target is a frame, as a tracker's; planes are looked at each by itself. Nests on the base "
        "(`nests.csv`) show it directly.",
    ),
    "sensor_slip": Shown(
        "sensor_slip:150", _injected("sensor_slip", target={"at": {"order": 150}}, size=1.0e-3)
    ),
    "range_scale": Shown(
        "range_scale",
        _injected("range_scale", size=2.0e-3),
        "It leaves no residual in this workcell, because the planes' distances grow with it: declare a plane as `known` to make it observable.",
    ),
    "range_offset": Shown("range_offset", _injected("range_offset", size=5.0e-4)),
    "range_distortion": Shown("range_distortion", _injected("range_distortion", size=2.0e-2)),
    "sensor_map": Shown(
        "sensor_map",
        {"injected": [], "scanner": {"linearity_m": 3.0e-4}},
        "The lens of the simulated scanner is crooked; the estimator's map is a polynomial over the profile.",
    ),
    "plane_bow": Shown("plane_bow:floor", _injected("plane_bow", target={"plane": "floor"}, size=1.0e-3)),
    "plane_moved": Shown(
        "plane_moved:wall_x:150",
        _injected("plane_moved", target={"plane": "wall_x", "at": {"order": 150}}, size=5.0e-4),
    ),
    "unattributed": Shown(
        "",
        _injected("unknown", kind="angle_bump", target={"joint": 3}, size=5.0e-4),
        "The joint's angle errs over a part of its range only, which no named effect does.",
    ),
}

NOISES: dict[str, Shown] = {
    "pose_jitter": Shown(
        "",
        _injected("pose_jitter", size=2.0e-4),
        "Each joint errs at each pose by a draw of its own; `noise: {joint_noise_std_rad: 2.0e-4}` in the scene does the same.",
    ),
    "scan_bias": Shown(
        "",
        _injected("scan_bias", size=2.0e-4),
        "All points of a scan err by one draw along the ray; `noise: {scan_bias_std_m: 2.0e-4}` in the scene does the same.",
    ),
}
"""The random errors of whole poses, which no effect of the registry describes."""


def simulated(shown: Shown, **changes: Any) -> Dataset:
    """Return a dataset of the scene in which an effect is shown, with further changes of the scene's keys."""
    from scalar.simulation import simulate, write_scene

    path = ROOT / SCENE
    scene = simulate({**load_yaml(path), **shown.changes, "truth_poses": 10, **changes}, path.parent)
    with tempfile.TemporaryDirectory() as folder:
        write_scene(scene, Path(folder))
        return read_dataset(Path(folder, "dataset"))


def effect_of(shown: Shown, dataset: Dataset) -> Effect:
    """Return the effect of a page, for a dataset of its scene, its coefficients zero."""
    name, *words = shown.words.split(":")
    return kind_named(name).parsed(dataset, words)[0]
