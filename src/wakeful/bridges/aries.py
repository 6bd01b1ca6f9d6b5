"""The planner Aries, in a worker process of its own (`aries_worker`): the extra ``planning``.

Give it to planning: ``plan(event, mind, PlanningSettings(task_s=10, planner=aries))``.
"""

from __future__ import annotations

import asyncio
import sys

import msgspec

from wakeful.contracts.treatment import Refusal
from wakeful.facts.errands import Errands

#: Importing the planner takes some seconds, more on a robot's computer.
START_S = 30.0


class PlannerError(Refusal):
    """The planner is not installed or failed; the message says which."""


async def aries(errands: Errands) -> dict[str, object]:
    """Have the worker plan; returns its Plan as plain data. A Planner.

    Raises:
        PlannerError: with what the worker said.
    """
    command = (sys.executable, "-m", "wakeful.bridges.aries_worker")
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
