"""Task planning: errands in an order that their constraints allow, by a planner in a process of its own."""

from __future__ import annotations

import asyncio
import os
from importlib.util import find_spec
from pathlib import Path

import msgspec
import pytest
from msgspec.structs import replace

from tests.treatments.worlds import DOMAIN, event, script
from wakeful.bridges.aries import PlannerError, aries
from wakeful.contracts.treatment import Mind
from wakeful.facts.domain import Errand, Task
from wakeful.facts.errands import Errands, Plan
from wakeful.facts.events import Context, Event
from wakeful.testing import ScriptedMind
from wakeful.treatments.errands import problem
from wakeful.treatments.planning import Planning, PlanningSettings, plan
from wakeful.treatments.routes import graph_of

DELIVER = Task(
    name="deliver",
    errands=(Errand(does="hand over", at="yard", after=("fetch",)), Errand(does="fetch", at="shelf")),
    end="dock",
)
WORLD = replace(DOMAIN, task=(DELIVER,))
TRIP = event("route_blocked", "hall", start="dock", goal="shelf", context=Context(task="deliver"))
needs_planner = pytest.mark.skipif(find_spec("unified_planning") is None, reason="the extra planning is not installed")


class WholeTask:
    """Planning that plans the whole task, too."""

    name, version, says, result = "planning", 1, "plans the task", Planning

    async def treat(self, about: Event, mind: Mind) -> Planning:
        """Within ten seconds."""
        return await plan(about, mind, PlanningSettings(planner=aries))


def treated(domain: object = WORLD, mode: str = "delib") -> Planning:
    result = ScriptedMind(domain, mode, script()).run(WholeTask(), TRIP)  # type: ignore[arg-type]
    assert isinstance(result, Planning)
    return result


def test_the_problem_is_the_task_over_what_is_left_of_the_graph() -> None:
    errands = problem(DELIVER, "dock", graph_of(DOMAIN))
    assert errands.places()[:4] == ("dock", "yard", "shelf", "hall")
    assert msgspec.json.decode(msgspec.json.encode(errands), type=Errands) == errands


def test_without_the_planner_the_treatment_says_what_to_install_and_plans_the_way_all_the_same(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "unified_planning.py").write_text("raise ImportError('it is not here')")
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join((str(tmp_path), os.environ.get("PYTHONPATH", ""))))
    result = treated()
    assert result.task_plan is None
    assert "pip install 'wakeful[planning]'" in result.no_task_plan
    assert result.plan is not None


def test_outside_deliberation_and_without_a_task_no_planner_is_started() -> None:
    assert (treated(mode="auto").task_plan, treated(mode="auto").no_task_plan) == (None, "")
    assert (treated(DOMAIN).task_plan, treated(DOMAIN).no_task_plan) == (None, "")


@needs_planner
def test_a_task_is_planned_round_what_is_blocked_in_the_order_that_it_needs() -> None:
    result = treated()
    assert result.task_plan is not None, result.no_task_plan
    steps = result.task_plan.steps
    assert steps.index("fetch at shelf") < steps.index("hand over at yard")
    assert steps[-1] == "go yard → dock"
    assert not any("hall" in step for step in steps)
    assert result.task_plan.cost == 4.0 + 4.0 + 4.0 + 4.0
    assert "(define (problem" in result.task_plan.pddl


@needs_planner
def test_a_task_that_cannot_be_done_is_a_result() -> None:
    alone = Errands(start="dock", errands=(Errand(does="fetch", at="moon"),), legs=(), within_s=5.0)
    assert not msgspec.convert(asyncio.run(aries(alone)), Plan).feasible


@needs_planner
def test_what_the_planner_cannot_read_is_an_error_with_its_words() -> None:
    broken = Errands(start="dock", errands=(Errand(does="fetch", at="shelf", after=("nothing",)),), legs=())
    with pytest.raises(PlannerError):
        asyncio.run(aries(broken))
