"""The worker process of task planning: one problem as JSON on standard input, its plan as JSON on standard output.

`python -m wakeful.bridges.aries_worker`. A process of its own, because importing the planner takes seconds and searching may
take longer than anybody wants the mind to stand still. Needs the extra ``planning`` (unified-planning and up-aries).
"""

from __future__ import annotations

import re
import sys
import tempfile
from pathlib import Path

import msgspec

from wakeful.facts.errands import Errands, Plan

_WORDS = re.compile(r"[a-z0-9]+")


def solve(errands: Errands) -> Plan:
    """Plan with Aries: one action for each leg and each errand, grounded, each with its cost.

    Source: Bit-Monnot 2023 (Aries); Micheli et al. 2025 (unified-planning).
    """
    import unified_planning.shortcuts as up  # noqa: PLC0415
    from unified_planning.io import PDDLWriter  # noqa: PLC0415

    up.get_environment().credits_stream = None
    problem = up.Problem("errands")
    at = {place: up.Fluent(_name("at", number, place)) for number, place in enumerate(errands.places())}
    done = {errand.does: up.Fluent(_name("done", number, errand.does)) for number, errand in enumerate(errands.errands)}
    for fluent in (*at.values(), *done.values()):
        problem.add_fluent(fluent, default_initial_value=False)
    problem.set_initial_value(at[errands.start], True)
    says: dict[str, str] = {}
    costs = {}
    for number, leg in enumerate(errands.legs):
        go = up.InstantaneousAction(_name("go", number, f"{leg.start} to {leg.end}"))
        go.add_precondition(at[leg.start])
        go.add_effect(at[leg.start], False)
        go.add_effect(at[leg.end], True)
        says[go.name] = f"go {leg.start} → {leg.end}"
        costs[go] = up.Int(round(leg.cost * 100))
        problem.add_action(go)
    for number, errand in enumerate(errands.errands):
        do = up.InstantaneousAction(_name("do", number, errand.does))
        do.add_precondition(at[errand.at])
        for before in errand.after:
            do.add_precondition(done[before])
        do.add_effect(done[errand.does], True)
        says[do.name] = f"{errand.does} at {errand.at}"
        costs[do] = up.Int(0)
        problem.add_action(do)
        problem.add_goal(done[errand.does])
    if errands.end:
        problem.add_goal(at[errands.end])
    problem.add_quality_metric(up.MinimizeActionCosts(costs))
    best = None
    with up.AnytimePlanner(name="aries") as planner:
        for found in planner.get_solutions(problem, timeout=errands.within_s):
            best = found if found.plan is not None else best
            status = found.status.name
    steps = tuple(says[each.action.name] for each in best.plan.actions) if best is not None else ()
    legs = {f"go {leg.start} → {leg.end}": leg.cost for leg in errands.legs}
    return Plan(
        feasible=best is not None,
        optimal=best is not None and status == "SOLVED_OPTIMALLY",
        steps=steps,
        cost=round(sum(legs.get(step, 0.0) for step in steps), 6),
        pddl=_pddl(PDDLWriter(problem)),
    )


def _name(what: str, number: int, says: str) -> str:
    """A name that PDDL takes, that is nobody else's, and that a person can read.

    >>> _name("at", 3, "Loading ramp (west)")
    'at_3_loading_ramp_west'
    """
    return "_".join([what, str(number), *_WORDS.findall(says.lower())])


def _pddl(writer: object) -> str:
    with tempfile.TemporaryDirectory() as folder:
        domain, problem = Path(folder) / "domain.pddl", Path(folder) / "problem.pddl"
        writer.write_domain(str(domain))  # type: ignore[attr-defined]
        writer.write_problem(str(problem))  # type: ignore[attr-defined]
        return domain.read_text() + "\n" + problem.read_text()


def main() -> None:
    """Read, plan, answer; the reason on standard error and exit code 1 where that fails."""
    try:
        plan = solve(msgspec.json.decode(sys.stdin.buffer.read(), type=Errands))
    except ImportError:
        sys.exit("task planning needs unified-planning and up-aries: pip install 'wakeful[planning]'")
    sys.stdout.buffer.write(msgspec.json.encode(plan))


if __name__ == "__main__":
    main()
