"""Import foreign files into a dataset."""
