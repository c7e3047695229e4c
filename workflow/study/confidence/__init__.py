"""The confidence of answers: the trials to which it is fitted, and how often answers are right that state it."""
