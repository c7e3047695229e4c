"""Which figures of the headline depend on the processor: the same calibrations with the arithmetic of several."""
