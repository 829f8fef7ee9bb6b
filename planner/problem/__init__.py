"""Options, requests, targets, the objective, outcomes and reasons; imports no robotics library."""
