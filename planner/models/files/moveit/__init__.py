"""MoveIt's formats: PlanningScene and MotionPlanRequest messages as YAML, and ``.scene`` text files."""
