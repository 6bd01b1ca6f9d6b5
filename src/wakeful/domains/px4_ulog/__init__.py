"""PX4 flights: what a flight log shows that deserves a thought, and what the flight later showed of it."""
