"""Gate and planner for programs in other languages: one process, messages in JSON or msgpack over a websocket."""
