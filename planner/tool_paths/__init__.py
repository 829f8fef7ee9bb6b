"""Tool paths: lines and arcs that the tool follows within a tube, over a ladder of inverse kinematics solutions."""
