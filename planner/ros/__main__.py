"""``python -m planner.ros``: run the node until Ctrl-C."""
# pyright: reportMissingImports=false

import sys
from collections.abc import Sequence

from planner.base.errors import InstallationError, PlannerError, require_extra
from planner.base.interrupts import write_message


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the node with the ``arguments`` of ROS; return the exit code."""
    try:
        rclpy = require_extra("rclpy", "ros")
    except InstallationError as error:
        write_message(f"{str(error).rstrip('.')} on Python 3.11, or source the setup file of ROS 2 first.")
        return error.exit_code
    from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor

    from planner.ros.node import PlannerNode

    node = None
    try:
        rclpy.init(args=arguments)
        node = PlannerNode()
        executor = MultiThreadedExecutor(4)
        executor.add_node(node)
        executor.spin()
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    except PlannerError as error:
        write_message(str(error))
        return error.exit_code
    finally:
        if node is not None:
            node.close()
        rclpy.try_shutdown()
    return 0


if __name__ == "__main__":
    sys.exit(main())
