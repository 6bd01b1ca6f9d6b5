"""The UR3 collaborative arm of the CobotOps recording: pick and place at one row a second."""
