"""Measured robots: the published files, the errors of models with more and more parameters on held-out poses, and the errors of the gears."""
