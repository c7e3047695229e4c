"""Effects that a scene's config plants, from its `planted` list: a file a place, and a catalogue of all."""
