"""Planned poses compared with random ones: the errors of calibrations over seeds."""
