"""Coverage: how often the true position of an arm lies within the ellipsoid that a calibration states for a predicted pose."""
