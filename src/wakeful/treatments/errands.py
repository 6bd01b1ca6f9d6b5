"""Task planning: the errands of a task in an order that its constraints allow, over what is left of the route graph.

The search runs in a worker process (`aries_worker`): the extra ``planning``. Without it, or where it fails, there is no plan of
the task, and the treatment says why.
"""

from __future__ import annotations

import asyncio
import sys

import msgspec

from wakeful.contracts.treatment import Refusal
from wakeful.facts.domain import Errand, Task
from wakeful.facts.values import Fact
from wakeful.treatments.routes import Graph

#: Importing the planner takes some seconds, more on a robot's computer.
START_S = 30.0


class Leg(Fact, frozen=True):
    """One free leg, in one direction."""

    start: str
    end: str
    cost: float


class Errands(Fact, frozen=True):
    """A planning problem: from where, what to do where and after what, where to end, over which legs."""

    start: str
    errands: tuple[Errand, ...]
    legs: tuple[Leg, ...]
    end: str = ""
    within_s: float = 5.0

    def places(self) -> tuple[str, ...]:
        """Every place that is named."""
        named = [self.start, *(errand.at for errand in self.errands), *([self.end] if self.end else [])]
        return tuple(dict.fromkeys([*named, *(place for leg in self.legs for place in (leg.start, leg.end))]))


class Plan(Fact, frozen=True):
    """The plan of a task. ``optimal``: the search showed that none costs less. ``pddl``: domain and problem, to be looked at."""

    feasible: bool
    optimal: bool = False
    steps: tuple[str, ...] = ()
    cost: float = 0.0
    pddl: str = ""


class PlannerError(Refusal):
    """The planner is not installed or failed; the message says which."""


def problem(task: Task, start: str, graph: Graph, within_s: float = 5.0) -> Errands:
    """The problem of a task from where the robot is, over what is left of the graph."""
    legs = [Leg(start=str(a), end=str(b), cost=float(graph.edges[a, b]["cost"])) for a, b in graph.edges]
    return Errands(start=start, errands=task.errands, legs=tuple(legs), end=task.end, within_s=within_s)


async def planned(errands: Errands) -> dict[str, object]:
    """Have the worker plan; returns its Plan as plain data. To be called outside the kernel.

    Raises:
        PlannerError: with what the worker said.
    """
    command = (sys.executable, "-m", "wakeful.treatments.aries_worker")
    pipe = asyncio.subprocess.PIPE
    worker = await asyncio.create_subprocess_exec(*command, stdin=pipe, stdout=pipe, stderr=pipe)
    try:
        said, wrong = await asyncio.wait_for(worker.communicate(msgspec.json.encode(errands)), errands.within_s + START_S)
    except TimeoutError:
        raise PlannerError(f"the planner did not answer within {errands.within_s + START_S:g} s") from None
    finally:
        if worker.returncode is None:
            worker.kill()
            await worker.wait()
    if worker.returncode:
        last = wrong.decode(errors="replace").strip().splitlines()[-1:]
        raise PlannerError(last[0][:300] if last else f"the planner ended with {worker.returncode}")
    return msgspec.json.decode(said, type=dict[str, object])
