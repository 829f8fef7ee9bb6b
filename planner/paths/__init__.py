"""Joint paths from any source: measured along their length, read from files, checked in a scene."""
