"""Effects that a scene's config injects, from its `injected` list: one file for each place where they act, and a catalogue of all."""
