"""A script for each package: it reads a job, fits with that package alone, and writes an answer. Only ``exchange`` is shared."""
