"""Flexible terms for structure that no named effect explains: they correct it at the measured poses without explaining it."""
