"""Files of robots, meshes and scenes."""
