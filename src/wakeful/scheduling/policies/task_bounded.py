"""Baseline: events outside the active task are ignored (Sec. IV-A, Task-Bounded)."""

from __future__ import annotations

from wakeful.facts.processes import ProcessView
from wakeful.scheduling.policies.sequential import Sequential


class TaskBounded(Sequential):
    """First come, first served over the events of the task alone; the others keep a process that never gets a slot."""

    name = "task_bounded"

    def serves(self, view: ProcessView) -> bool:
        """Only what concerns the active task."""
        return view.task_relevant
