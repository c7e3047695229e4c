"""Errors at poses that took no part: in a fit, or in the whole diagnosis."""
