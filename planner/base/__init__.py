"""Arrays, errors, files, progress and resolutions for all other packages; imports none of them."""
