"""Whether sensor and targets are where they are said to be, and measure in the stated axes and in the stated scale."""
