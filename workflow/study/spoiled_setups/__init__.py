"""Spoiled set-ups: one thing about the description of a sound simulated campaign is made wrong at random, and what the software says is scored."""
