"""Where calibration and diagnosis break: one thing wrong with the data, more and more of it."""
