"""The words of the field for effects and for the cases of the blind trials, in figures and in the paper."""

from __future__ import annotations

WORDS = {
    "joint_compliance": "joint compliance",
    "torque_compliance": "compliance by measured torque",
    "payload_deflection": "deflection under a payload",
    "base_compliance": "base compliance",
    "joint_harmonic": "harmonic of a gear",
    "joint_ripple": "gear error of many orders",
    "joint_scale": "scale error of a joint",
    "joint_coupling": "coupling of joints",
    "joint_backlash": "backlash",
    "joint_hysteresis": "hysteresis of a joint",
    "pose_lag": "lag of joints",
    "axis_nonparallel": "tilted axis",
    "thermal_drift": "thermal drift",
    "restarted_warm_up": "warm-up with breaks",
    "target_drift": "drift of the tracker",
    "sensor_slip": "slipped scanner",
    "range_scale": "range gain",
    "range_offset": "range offset",
    "range_distortion": "range distortion",
    "sensor_map": "map of the scanner's error",
    "plane_bow": "bowed plane",
    "plane_moved": "moved plane",
    "pose_jitter": "jitter of the joints",
    "scan_bias": "error common to a scan",
    "angle_bump": "bump over an angle",
    "angle_step": "step over an angle",
    "angle_product": "product of two angles",
    "angle_sum": "sum of two angles",
    "base_sway": "swaying base",
    "belt": "belt",
    "encoder_drift": "drifting encoder",
    "forearm_spring": "error over two angles",
    "late_jump": "late jump",
    "sensor_oscillation": "swaying scanner",
    "worn_teeth": "worn teeth",
    "null": "nothing",
    "none": "nothing",
    "failed": "no answer",
}
"""``{name of an effect, of an unknown cause or of an answer: words}``; other names are words already."""
VARIANTS = {"unrecorded": "side unrecorded", "by-time": "by time"}
"""``{variant of a case: words}``; an underscore in another variant stands for a space."""
UNKNOWN = "unknown"  # first part of a case whose second part names a cause that is no effect of the catalogue


def case_words(case: str) -> str:
    """Return an effect, or a case of the blind trials such as ``plane_moved-creeping`` or ``unknown-belt``, in words."""
    name, _, variant = case.partition("-")
    if name == UNKNOWN and variant:
        return f"{UNKNOWN}: {WORDS[variant]}"
    text = WORDS.get(name, name)
    return f"{text}, {VARIANTS.get(variant, variant.replace('_', ' '))}" if variant else text
