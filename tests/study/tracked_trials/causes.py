"""Causes that are injected into a tracked arm, as the design of the trials states them."""

SIZES = {"joint_harmonic": 3e-4, "joint_scale": 1e-3, "joint_backlash": 4e-4, "pose_lag": 1e-3}


def cause(name, target=None, **more):
    """Return an injected cause."""
    return {"name": name, "target": target or {}, "size": SIZES.get(name, 1e-5), **more}
