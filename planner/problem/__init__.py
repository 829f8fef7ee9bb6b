"""What is asked: options of a request, targets, the objective, outcomes and reasons; loads no library."""
