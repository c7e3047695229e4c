"""Flexible terms for structure that no named effect explains: they correct, and say that they are no explanation."""
