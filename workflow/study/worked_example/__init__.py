"""One diagnosis followed step by step, from the residual to the effect."""
