"""Which poses to measure: those from which a calibration predicts best, and those that separate causes which a diagnosis could not distinguish."""
