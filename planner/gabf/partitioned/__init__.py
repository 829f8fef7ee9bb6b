"""GABF on a network cut into blocks: each knows its own nodes and, of the others, those that it reads."""
