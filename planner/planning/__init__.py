"""One plan: the network of an objective on a roadmap, floors, healing, and what a plan holds and writes."""
