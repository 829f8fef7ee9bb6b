"""Gate and planner for programs in other languages: one process, JSON messages over a websocket."""
