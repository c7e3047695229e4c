"""Which named effects are added to the model: one after the other, as whole sets, and given errors of the instrument."""
