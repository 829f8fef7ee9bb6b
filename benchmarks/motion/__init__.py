"""Motions of a folder of planning problems: how long they take, what they break, what they touch."""
