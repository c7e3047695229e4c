"""At which degree of gross errors, wrong noise or poor guesses calibration and diagnosis fail: one thing is wrong at a time."""
