"""Vehicles of the fleet standard VDA 5050, seen through their state messages (versions 1.1 to 3.0)."""
