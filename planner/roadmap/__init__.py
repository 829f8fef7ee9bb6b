"""The roadmap: a graph of collision-free configurations whose edges are proven. Start with :func:`build_roadmap`."""
