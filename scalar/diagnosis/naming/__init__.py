"""What is reported of the effects that were found: their names, what is confounded with them, and the confidence in each."""
