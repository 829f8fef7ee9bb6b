"""What motions keep all along: conditions on the pose of a frame, seen in states, proven on curves, projected onto."""
