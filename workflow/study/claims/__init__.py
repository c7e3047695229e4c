"""Every claim of the original paper judged by stated rules on the results of a run."""
