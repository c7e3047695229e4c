"""Measured robots: the published files, models of increasing size on held-out poses, and the errors of their gears."""
