"""Is the set-up what dataset.yaml says? Signs, zeros, conventions, units, labels and order are hypotheses too."""
