"""The search on a roadmap: the field, its path, a recheck of the path, and healing after a removal."""
