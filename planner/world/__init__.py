"""Who stands where: robots, scenes, shapes, and the files they come from."""
