"""Planning: a way round on the route graph, or the written steps where the domain has no graph. Infeasible is a result."""

from __future__ import annotations

from itertools import pairwise
from typing import Literal

from msgspec import convert
from msgspec.structs import replace

from wakeful.contracts.treatment import Mind, Refusal
from wakeful.facts.errands import Plan, Planner
from wakeful.facts.events import Event
from wakeful.facts.results import Forecast, Proposal, Result
from wakeful.facts.time import to_ns
from wakeful.facts.values import Fact
from wakeful.treatments.consulting import consult
from wakeful.treatments.decorator import treatment
from wakeful.treatments.errands import problem
from wakeful.treatments.forecasting import expectation, forecast_reasons, pooled, recalled_voice
from wakeful.treatments.procedure import Step, steps_for
from wakeful.treatments.remembering import resting, similar
from wakeful.treatments.routes import Graph, Trip, Way, cost_of, graph_of, impassable, leg_name, trip_of, ways, without
from wakeful.treatments.sureness import NOTHING_TO_GO_ON, sentence, sure
from wakeful.treatments.wording import brief, subject

#: A planner may take so long before it begins to search.
STARTING_S = 60.0


class PlanningSettings(Fact, frozen=True):
    """How many ways are worked out, and how many like cases are asked how they ended."""

    ways: int = 2
    ways_deliberating: int = 5
    cases: int = 6
    task_s: float = 10.0
    """For how long the plan of the whole task is searched when deliberating."""
    planner: Planner | None = None
    """Who plans whole tasks, such as ``wakeful.bridges.aries.aries`` (the extra ``planning``); None: nobody."""


class Proposed(Fact, frozen=True):
    """A reasoner's way, from start to goal by the graph's own names."""

    nodes: tuple[str, ...]


class Planning(Result, frozen=True, kw_only=True, tag="planning"):
    """The plan. ``method`` says what it is: searched on the route graph, written steps in order, or nothing."""

    method: Literal["route", "procedure", "none"]
    feasible: bool | None = None
    """None: nothing was searched, so nobody knows."""
    start: str = ""
    goal: str = ""
    detour: bool = False
    blocked: tuple[str, ...] = ()
    plan: Way | None = None
    alternatives: tuple[Way, ...] = ()
    steps: tuple[Step, ...] = ()
    extra_cost: float | None = None
    """What the plan costs beyond the cheapest way with nothing blocked."""
    old_plan_fails: str = ""
    task_plan: Plan | None = None
    no_task_plan: str = ""
    """Why the task has none, where one was wanted."""


@treatment(
    "planning",
    result=Planning,
    says="Plans a way round what blocks a route or a task, with alternatives, their cost and what they depend on.",
)
async def planning(event: Event, mind: Mind) -> Planning:
    """Search the domain's route graph without what the event blocks, or put the written steps in order."""
    return await plan(event, mind, PlanningSettings())


async def plan(event: Event, mind: Mind, settings: PlanningSettings) -> Planning:
    """The thinking of ``planning`` with settings of one's own."""
    await mind.work(1)
    past = await similar(event, mind, settings.cases)
    await mind.work(1)
    voice = recalled_voice(mind, event, past)
    forecast = pooled(mind, event, [voice])
    reasons = (*resting(case for case in past if case.outcome), *forecast_reasons(mind, [voice]))
    graph = graph_of(mind.domain)
    trip = trip_of(event, graph)
    if not (trip.start and trip.goal):
        return _procedure(event, mind, trip, bool(mind.domain.route), forecast, reasons)

    if mind.mode == "delib":
        await mind.work(1)
    left = without(graph, trip)
    count = settings.ways_deliberating if mind.mode == "delib" else settings.ways
    found = ways(left, trip.start, trip.goal, count)
    asked = await consult(
        event,
        mind,
        "planning",
        f"Which way from {trip.start} to {trip.goal} should the robot take, as the list of nodes? Start and goal included.",
        Proposed,
        lambda way: impassable(left, way.nodes, trip),
        past,
        [leg_name(leg) for leg in left.edges],
    )
    if asked.answer is not None:
        found = _with(found, asked.answer.nodes, left)
    before = ways(graph, trip.start, trip.goal, 1)
    blocked = (*trip.shut_nodes, *(leg_name(leg) for leg in trip.shut_legs))
    extra = round(found[0].cost - before[0].cost, 6) if found and before else None
    fails = _fails(before[0] if before else None, trip, blocked)
    task_plan, no_task_plan = await _task_plan(event, mind, left, trip.start, settings)
    best = found[0] if found else None
    return Planning(
        says=sentence(mind, subject(event), _found(trip, best, extra, blocked, len(found)), expectation(forecast)),
        confidence=sure(mind, 0.5 if trip.detour else 0.85),
        rests_on=(
            f"event {event.id}",
            f"route graph of {mind.domain.name} version {mind.domain.version}",
            *reasons,
            *asked.basis,
        ),
        would_change=_would_change(trip, best, blocked),
        forecast=forecast,
        proposes=_proposal(event, mind, best, blocked),
        consulted=asked.consulted,
        method="route",
        feasible=best is not None,
        start=trip.start,
        goal=trip.goal,
        detour=trip.detour,
        blocked=blocked,
        plan=best,
        alternatives=found[1:],
        extra_cost=extra,
        old_plan_fails=fails,
        task_plan=task_plan,
        no_task_plan=no_task_plan,
    )


async def _task_plan(event: Event, mind: Mind, left: Graph, start: str, settings: PlanningSettings) -> tuple[Plan | None, str]:
    """The plan of the task that the event's context names, from where the robot is; or why there is none."""
    task = next((each for each in mind.domain.task if each.name == event.context.task), None)
    if task is None or mind.mode != "delib" or settings.planner is None:
        return None, ""
    errands = problem(task, start, left, settings.task_s)

    planner = settings.planner

    async def search() -> dict[str, object]:
        return await planner(errands)

    try:
        answer: dict[str, object] = await mind.call(search, f"task {task.name}", settings.task_s + STARTING_S)
    except Refusal as refusal:
        return None, str(refusal)
    found = convert(answer, Plan)
    return found, "" if found.feasible else f"no order of its errands can be driven on what is left of the graph from {start}"


def _with(found: tuple[Way, ...], nodes: tuple[str, ...], left: Graph) -> tuple[Way, ...]:
    """The ways with a reasoner's among them: it is the plan where none that was found costs less."""
    others = (way for way in found if way.nodes != nodes)
    # the sort is stable, so a tie is the reasoner's
    first, *rest = sorted((Way(nodes=nodes, cost=cost_of(left, nodes)), *others), key=lambda way: way.cost)
    # a leg that no way can do without is in every way, and the first says it
    return (replace(first, depends_on=found[0].depends_on), *(replace(way, depends_on=()) for way in rest))


def _found(trip: Trip, best: Way | None, extra: float | None, blocked: tuple[str, ...], count: int) -> str:
    because = f" with {', '.join(blocked)} blocked" if blocked else ""
    if best is None:
        return f": no way is left from {trip.start} to {trip.goal}{because}"
    more = f", {extra:g} more than before" if extra else ""
    others = f"; {count - 1} other way{'s' if count > 2 else ''}" if count > 1 else "; no other way was found"
    whole = len(best.depends_on) == len(best.nodes) - 1
    hangs = (
        "; every leg of it is indispensable"
        if whole
        else f"; all hangs on {', '.join(best.depends_on)}"
        if best.depends_on
        else ""
    )
    return f": {'detour' if trip.detour else 'go'} {' → '.join(best.nodes)}, cost {best.cost:g}{more}{because}{others}{hangs}"


def _fails(before: Way | None, trip: Trip, blocked: tuple[str, ...]) -> str:
    if before is None:
        return f"there never was a way from {trip.start} to {trip.goal}"
    legs = set(pairwise(before.nodes))
    shut = [node for node in trip.shut_nodes if node in before.nodes]
    shut += [leg_name(leg) for leg in trip.shut_legs if leg in legs or leg[::-1] in legs]
    if shut:
        return f"{' → '.join(before.nodes)} passes {', '.join(shut)}"
    return "" if not blocked else f"it does not fail: {' → '.join(before.nodes)} passes nothing that is blocked"


def _would_change(trip: Trip, best: Way | None, blocked: tuple[str, ...]) -> tuple[str, ...]:
    cleared = tuple(f"{name} is free again" for name in blocked)
    hangs = tuple(f"{name} is blocked too" for name in best.depends_on) if best is not None else ()
    told = ("the robot's own start and goal",) if trip.detour else ()
    return (*cleared, *hangs, *told) or ("a leg of the plan is blocked",)


def _proposal(event: Event, mind: Mind, best: Way | None, blocked: tuple[str, ...]) -> tuple[Proposal, ...]:
    if best is None or not blocked:
        return ()
    still = tuple(f"{name} is still blocked" for name in blocked)
    free = tuple(f"{leg_name(leg)} is free" for leg in pairwise(best.nodes))
    until_ns = event.stamp.received_ns + to_ns(mind.domain.outcome.within_s)
    effect = f"take {' → '.join(best.nodes)}"
    # where people are near, a person decides
    who: Literal["operator", "supervisor"] = "operator" if event.context.safety else "supervisor"
    return (Proposal(effect=effect, preconditions=(*still, *free), authority=who, valid_until_ns=until_ns),)


def _procedure(
    event: Event, mind: Mind, trip: Trip, has_graph: bool, forecast: Forecast | None, reasons: tuple[str, ...]
) -> Planning:
    """Without a trip on a graph: the steps that the domain's tables write down, in order, and said to be just that."""
    steps = steps_for(event, mind.domain)
    why = "the event names no start, goal or leg of the route graph" if has_graph else "the domain has no route graph"
    listed = "; ".join(f"{at}. {brief(step.does, 80)}" for at, step in enumerate(steps, 1))
    said = f": {listed} (written steps; no way was searched, because {why})" if steps else f": no plan, because {why}"
    said += "" if steps else " and none of its tables has a step for this"
    return Planning(
        says=sentence(mind, subject(event), said, expectation(forecast)),
        confidence=sure(mind, 0.4 if steps else NOTHING_TO_GO_ON),
        rests_on=(f"event {event.id}", *(step.source for step in steps), *reasons),
        would_change=("a start and a goal on the route graph" if has_graph else "a route graph or a guideline for this event",),
        forecast=forecast,
        method="procedure" if steps else "none",
        start=trip.start,
        goal=trip.goal,
        steps=steps,
    )
