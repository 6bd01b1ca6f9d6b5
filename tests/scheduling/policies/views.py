"""What policies are told in tests: views with only what a test is about."""

from __future__ import annotations

from wakeful.facts.processes import ProcessView
from wakeful.facts.time import NS_PER_S, to_ns


def seen(
    number: int,
    at_s: float = 0,
    *,
    left: int | None = None,
    done: int = 0,
    critical: bool = False,
    criticality: int = 0,
    deadline_s: float | None = None,
    waits: bool | None = False,
    started_s: float | None = None,
    priority: int = 0,
    kind: str = "",
    relevant: bool = True,
    due_s: float | None = None,
) -> ProcessView:
    """A process that came at ``at_s``, with ``left`` steps to do after the ``done`` ones (None: nobody says)."""
    return ProcessView(
        id=number,
        event=f"e{number}",
        treatment="t",
        mode="auto",
        criticality=3 if critical else criticality,
        arrived_ns=to_ns(at_s),
        steps_done=done,
        task_relevant=relevant,
        priority=priority,
        deadline_ns=None if deadline_s is None else to_ns(deadline_s),
        steps_needed=None if left is None else done + left,
        kind=kind,
        started_ns=None if started_s is None else to_ns(started_s),
        spent_ns=done * NS_PER_S,
        needs_evidence=waits,
        evidence_due_ns=None if due_s is None else to_ns(due_s),
    )
