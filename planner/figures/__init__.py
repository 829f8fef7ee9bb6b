"""Figures for papers and notebooks: the only room that imports matplotlib."""
