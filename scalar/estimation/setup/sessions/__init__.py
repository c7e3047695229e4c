"""Whether sessions are stated, and whether each determines where its target is."""
