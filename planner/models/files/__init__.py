"""The files that models come from: URDF, SRDF, xacro, MJCF, meshes, MoveIt's messages, robot and scene files."""
