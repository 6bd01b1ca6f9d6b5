"""Wheeled mobile robots, from ROS recordings: what happens on the way that no task asked for."""
