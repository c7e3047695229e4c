"""Side-by-side times, made by ``make bench``: ratios within one process, never a test."""
