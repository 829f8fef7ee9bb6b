"""The roadmap: a graph of free configurations with proven edges. Start with :func:`build_roadmap`."""
