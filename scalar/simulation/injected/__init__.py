"""Effects that a scene's config injects, from its list `injected`: a module for each place where effects act, and a catalogue of all effects."""
