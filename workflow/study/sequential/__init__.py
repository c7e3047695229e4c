"""The calibration of scanner and arm at once, compared with calibrations of one after the other, in every order."""
