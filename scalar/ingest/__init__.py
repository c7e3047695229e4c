"""Foreign files into a dataset."""
