"""Task planning: the errands of a task as a problem over what is left of the route graph."""

from __future__ import annotations

from wakeful.facts.domain import Task
from wakeful.facts.errands import Errands, Leg
from wakeful.treatments.routes import Graph


def problem(task: Task, start: str, graph: Graph, within_s: float = 5.0) -> Errands:
    """The problem of a task from where the robot is, over what is left of the graph."""
    legs = [Leg(start=str(a), end=str(b), cost=float(graph.edges[a, b]["cost"])) for a, b in graph.edges]
    return Errands(start=start, errands=task.errands, legs=tuple(legs), end=task.end, within_s=within_s)
