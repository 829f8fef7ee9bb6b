"""MoveIt's formats: PlanningScene and MotionPlanRequest messages as YAML, and ``.scene`` text files.

Every field of a message is honoured, noted as passed over, or refused by name: :mod:`.moveit.fields`.
"""
