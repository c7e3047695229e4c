"""The headline study: simulate, calibrate, evaluate and summarise one case over many seeds, and what its poses can identify."""
