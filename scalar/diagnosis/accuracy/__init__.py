"""How far the predictions of a calibration err: by chance, and by what its model may lack."""
