"""``planner robots`` and ``planner scenes``: what is there."""

from __future__ import annotations

from planner.cli.common import Flag
from planner.cli.terminal import show


def robots(debug: Flag = False) -> int:
    """List the robots, with their joints and limits.

    Args:
        debug: Show tracebacks of errors.
    """
    from rich.table import Table

    from planner.base.resources import robot_names
    from planner.world.robot import Robot

    table = Table("robot", "joint", "from", "to", "unit", "tool frame")
    for name in robot_names():
        robot = Robot.load(name)
        for k, joint in enumerate(robot.joints):
            first = k == 0
            unit = "m" if robot.prismatic[k] else "rad, turns freely" if robot.continuous[k] else "rad"
            table.add_row(
                name if first else "",
                joint,
                f"{robot.lower[k]:.4f}",
                f"{robot.upper[k]:.4f}",
                unit,
                robot.tool if first else "",
            )
        table.add_section()
    show(table)
    return 0


def scenes(debug: Flag = False) -> int:
    """List the scenes, with their obstacles and named states.

    Args:
        debug: Show tracebacks of errors.
    """
    from rich.table import Table

    from planner.base.resources import scene_names
    from planner.world.scene import Scene

    table = Table("scene", "description", "obstacles", "robots: named states")
    for name in scene_names():
        scene = Scene.load(name)
        states = "\n".join(f"{robot}: {', '.join(named)}" for robot, named in scene.states.items())
        table.add_row(name, scene.description, _some([o.name for o in scene.obstacles]), states)
        table.add_section()
    show(table)
    return 0


def _some(names: list[str], most: int = 8) -> str:
    """The first few of a list, and how many more there are."""
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return (", ".join(names[:most]) or "none") + more
