"""How a plan at one beta compares with the path of a sweep."""
