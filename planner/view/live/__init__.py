"""The live page on viser."""
