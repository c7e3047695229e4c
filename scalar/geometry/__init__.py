"""Rigid geometry: transforms, serial chains and planes; knows no data."""
