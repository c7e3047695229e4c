"""Which numbers of the headline study depend on the processor: the same calibrations with the arithmetic of several processors."""
