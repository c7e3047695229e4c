"""Whether what remains is noise, and where it comes from: the sensor, the joints, or each scan as a whole."""
