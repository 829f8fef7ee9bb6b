"""Path constraints: conditions on the pose of a frame, checked in states and proven on curves."""
