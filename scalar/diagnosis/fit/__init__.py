"""A model fitted to a dataset: its residual and Jacobian, the columns of effects at its optimum, and the variance components of its poses."""
