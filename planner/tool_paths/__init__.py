"""Tool paths: lines and arcs of the tool in a tube, over a ladder of inverse kinematics solutions."""
