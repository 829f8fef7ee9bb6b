"""Something taken and put elsewhere: grasps, paths and placements chosen together, by one field over all modes."""
