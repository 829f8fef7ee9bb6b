"""From a request to the robot in its scene, and to start and goal configurations."""
