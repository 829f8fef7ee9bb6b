"""Joint paths, whoever made them: measured along their way, read from files, checked in a scene."""
