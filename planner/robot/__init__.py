"""Robots, scenes, shapes and moving obstacles, and the files that describe them."""
