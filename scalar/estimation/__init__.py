"""From a dataset to a calibration: model, residuals, least squares, identifiability, result."""
