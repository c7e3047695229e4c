"""From residual to the effect that the model lacks: clean, score, add, refit, judge on held-out poses, repeat."""
