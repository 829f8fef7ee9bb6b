"""The ROS 2 node: ``python -m planner.ros``. Only this package imports rclpy and messages of ROS 2."""
