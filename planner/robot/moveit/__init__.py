"""MoveIt's scenes and requests."""
