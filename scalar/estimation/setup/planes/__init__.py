"""Whether planes are where they are guessed or declared known, and were measured from one side."""
