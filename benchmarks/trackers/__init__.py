"""Calibration packages on one set of tracker data, each in an environment of its own: ``make bench-trackers``."""
