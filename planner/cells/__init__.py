"""Plans of several robots in one cell, one after the other on a roadmap of each."""
