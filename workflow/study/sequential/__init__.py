"""Calibrating scanner and arm at once compared with calibrating one after the other, in every order."""
