"""Structure that no named effect explains, described by flexible terms."""
