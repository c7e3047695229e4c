"""Effects that a scene's config injects, from its `injected` list: a file a place, and a catalogue of all."""
