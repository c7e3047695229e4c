"""Whether the arm is the one of the data sheet: its lengths, zeros, signs, units and joints."""
