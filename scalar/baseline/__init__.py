"""The calibration exactly as the original paper prints it, for comparison; use ``scalar.estimation`` to calibrate."""
