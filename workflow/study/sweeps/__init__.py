"""The sweeps: errors over one setting of the scene at a time, every case in memory, beside the Cramér-Rao bound."""
