"""The sweeps: the errors over one setting of the scene at a time, with the Cramér-Rao bound for comparison."""
