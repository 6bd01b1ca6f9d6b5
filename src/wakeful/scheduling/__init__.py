"""The process set, and the scheduler that gives its members slots."""

from wakeful.scheduling.policies.suspend_resume import SuspendResume
from wakeful.scheduling.process_set import ProcessSet
from wakeful.scheduling.scheduler import Scheduler

__all__ = ["ProcessSet", "Scheduler", "SuspendResume"]
