"""Roadmaps built, connected to new ends, improved, extended and repaired; and why a roadmap holds no path."""
