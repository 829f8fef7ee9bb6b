"""From a roadmap to the network that GABF solves."""
