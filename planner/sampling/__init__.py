"""Sampling: OMPL's tree planners, first paths, growth, informed sets, connections of near neighbours."""
