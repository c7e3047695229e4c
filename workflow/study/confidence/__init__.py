"""The confidence of answers: the answers of trials, the fit of the confidence to them, and how often answers with a stated confidence are right."""
