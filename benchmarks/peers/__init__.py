"""Workload W through wakeful, what a user would pick instead, and the floor that hardware and libraries allow."""
