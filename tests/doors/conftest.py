"""Tests of doors that need ROS 2 or a bridge to it: `make doors` runs them, in an environment of their own."""

from importlib.util import find_spec

collect_ignore_glob = [] if find_spec("rclpy") else ["test_*.py"]
