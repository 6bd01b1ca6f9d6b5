from tests.treatments.worlds import BARE, DOMAIN, NOW_S, episode, event, script
from wakeful.facts.events import Context
from wakeful.facts.time import to_ns
from wakeful.testing import ScriptedMind
from wakeful.treatments.planning import Planning, planning


def planned(kind: str = "route_blocked", entity: str = "hall", mode: str = "auto", **fields: object) -> Planning:
    result = ScriptedMind(DOMAIN, mode, script()).run(planning, event(kind, entity, **fields))  # type: ignore[arg-type]
    assert isinstance(result, Planning)
    return result


def test_the_plan_goes_round_what_is_blocked_and_says_what_it_costs_more_and_why_the_old_one_fails() -> None:
    result = planned(start="dock", goal="loft")
    assert result.plan is not None
    assert result.plan.nodes == ("dock", "yard", "shelf", "loft")
    assert (result.plan.cost, result.extra_cost) == (9.0, 3.0)
    assert result.old_plan_fails == "dock → hall → shelf → loft passes hall"
    [proposal] = result.proposes
    assert "hall is still blocked" in proposal.preconditions
    assert proposal.valid_until_ns == to_ns(NOW_S + 60.0)


def test_no_way_left_is_a_result_and_no_error() -> None:
    result = planned("route_blocked", "shelf", start="dock", goal="loft")
    assert result.feasible is False
    assert result.plan is None
    assert result.proposes == ()
    assert "no way is left from dock to loft with shelf blocked" in result.says


def test_deliberating_works_out_more_alternatives() -> None:
    quick, long = planned("trip", "r", start="dock", goal="shelf"), planned("trip", "r", "delib", start="dock", goal="shelf")
    assert len(quick.alternatives) == 1
    assert len(long.alternatives) >= len(quick.alternatives)
    assert [way.cost for way in long.alternatives] == sorted(way.cost for way in long.alternatives)


def test_a_plan_that_nothing_blocks_proposes_nothing() -> None:
    result = planned("trip", "r", start="dock", goal="shelf")
    assert result.feasible
    assert result.proposes == ()
    assert result.old_plan_fails == ""


def test_near_people_a_person_decides_whether_to_take_the_way() -> None:
    calm = planned(start="dock", goal="loft")
    people = planned(start="dock", goal="loft", context=Context(safety=True))
    assert (calm.proposes[0].authority, people.proposes[0].authority) == ("supervisor", "operator")


def test_a_detour_without_a_trip_is_less_sure_than_a_way_for_a_known_trip() -> None:
    assert planned().confidence < planned(start="dock", goal="loft").confidence
    assert planned().detour


def test_without_a_graph_the_written_steps_come_in_order_and_are_said_to_be_just_that() -> None:
    result = planned("current_high", "J3", state="unstable")
    assert result.method == "procedure"
    assert result.feasible is None
    assert [step.does for step in result.steps] == [
        "keep away",  # the severest hazard first
        "slow down",
        "listen to the gear",  # then checks, the likelier fault first
        "look",
        "replace the gear",  # then remedies, once their fault is confirmed
        "clear",
        "watch for 1 min what comes of it (none, stop, drop)",
    ]
    assert result.steps[4].preconditions == ("worn gear is confirmed",)
    assert "no way was searched" in result.says


def test_with_neither_graph_nor_steps_there_is_no_plan_and_it_says_why() -> None:
    result = ScriptedMind(BARE, "delib", script()).run(planning, event("sighting", "thing"))
    assert isinstance(result, Planning)
    assert result.method == "none"
    assert "no plan, because the domain has no route graph" in result.says


def test_how_like_cases_ended_bears_on_the_forecast() -> None:
    ended = tuple(episode(f"e{at}", 100.0 + at, kind="route_blocked", outcome="drop") for at in range(6))
    result = ScriptedMind(DOMAIN, "auto", script(*ended)).run(planning, event("route_blocked", "hall"))
    assert result.forecast is not None
    assert result.forecast.label == "drop"
