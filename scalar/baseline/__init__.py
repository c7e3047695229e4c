"""The calibration as the original paper prints it: to be compared with, not to be used."""
