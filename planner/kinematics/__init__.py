"""Questions about a configuration that need no obstacles: where the links are, how well the arm can move."""
