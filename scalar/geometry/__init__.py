"""Rigid geometry: transforms, serial chains and planes, without any knowledge of data."""
