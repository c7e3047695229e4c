"""Planned poses compared with random ones: the errors of calibrations, and whether further poses separate confounded causes."""
