"""The candidates for a dataset, and how much of a residual each of them would explain."""
