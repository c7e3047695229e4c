"""Flexible terms for structure that no named effect explains: they correct it near the measured poses without naming its cause."""
