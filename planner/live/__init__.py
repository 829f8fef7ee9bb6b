"""A page on which the world can be changed: what it asks for, what is done about it, and what it is shown."""
