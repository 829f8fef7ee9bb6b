"""``python -m planner.ros``: run the node until Ctrl-C."""
# pyright: reportMissingImports=false

import sys
import threading
from collections.abc import Sequence

from planner.base.errors import InstallationError, OptionError, PlannerError, require_extra
from planner.base.interrupts import catch_signals, write_message


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the node with the ``arguments`` of ROS; return the exit code."""
    try:
        rclpy = require_extra("rclpy", "ros")
    except InstallationError as error:
        write_message(f"{str(error).rstrip('.')} on Python 3.11, or source the setup file of ROS 2 first.")
        return error.exit_code
    from rclpy.executors import MultiThreadedExecutor
    from rclpy.signals import SignalHandlerOptions

    from planner.ros.node import PlannerNode

    asked = threading.Event()
    with catch_signals(asked, "left without waiting for a plan."):
        try:
            rclpy.init(args=arguments, signal_handler_options=SignalHandlerOptions.NO)
            node, executor = PlannerNode(), MultiThreadedExecutor(4)
        except PlannerError as error:
            write_message(str(error))
            return error.exit_code
        except RuntimeError as error:  # of arguments that ROS cannot read
            write_message(" ".join(str(error).split()))
            return OptionError.exit_code
        executor.add_node(node)
        thread = threading.Thread(target=executor.spin, name="executor")
        thread.start()
        while not asked.wait(0.5):
            pass
        node.close()
        executor.shutdown()
        thread.join()
        node.destroy_node()
        rclpy.shutdown()
    return 0


if __name__ == "__main__":
    sys.exit(main())
