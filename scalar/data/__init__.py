"""Measured data: datasets, their description, and every fault in them."""
