import networkx as nx
from hypothesis import given
from hypothesis import strategies as st

from tests.treatments.worlds import DOMAIN, event
from wakeful.facts.domain import DomainSpec, Route
from wakeful.facts.events import Context
from wakeful.treatments.routes import Trip, graph_of, trip_of, ways, without

GRAPH = graph_of(DOMAIN)

nodes = st.sampled_from("abcdef")
routes = st.lists(st.builds(Route, start=nodes, end=nodes, cost=st.floats(0.0, 10.0), two_way=st.booleans()), max_size=12)


@given(routes, nodes, nodes, st.integers(1, 4))
def test_the_ways_are_executable_on_the_graph_cheapest_first_and_the_first_is_the_shortest(
    edges: list[Route], start: str, goal: str, count: int
) -> None:
    graph = graph_of(DomainSpec(name="d", version=1, says="d", route=tuple(edges)))
    found = ways(graph, start, goal, count)
    assert len(found) <= count
    assert list(found) == sorted(found, key=lambda way: way.cost)
    for way in found:
        assert way.nodes[0] == start
        assert way.nodes[-1] == goal
        assert all(graph.has_edge(a, b) for a, b in zip(way.nodes, way.nodes[1:], strict=False))
    reachable = start in graph and goal in graph and nx.has_path(graph, start, goal)
    assert bool(found) == reachable
    if reachable:
        shortest = nx.shortest_path_length(graph, start, goal, weight="cost")
        assert abs(found[0].cost - shortest) <= 1e-5 * max(shortest, 1.0)


@given(routes, nodes, nodes)
def test_what_a_way_depends_on_is_what_it_cannot_do_without(edges: list[Route], start: str, goal: str) -> None:
    graph = graph_of(DomainSpec(name="d", version=1, says="d", route=tuple(edges)))
    for way in ways(graph, start, goal, 1):
        for leg in zip(way.nodes, way.nodes[1:], strict=False):
            left = graph.copy()
            left.remove_edge(*leg)
            assert ("–".join(leg) in way.depends_on) == (not nx.has_path(left, start, goal))


def test_a_trip_is_read_from_fields_whatever_the_case_and_a_leg_in_any_usual_spelling() -> None:
    for leg in ("dock-hall", "Hall -> Dock", "dock|hall", "hall to dock"):
        trip = trip_of(event("route_blocked", "r", start="DOCK", goal="loft", blocked=leg), GRAPH)
        assert (trip.start, trip.goal) == ("dock", "loft")
        assert {frozenset(each) for each in trip.shut_legs} == {frozenset(("dock", "hall"))}
        assert not trip.detour


def test_a_node_whose_name_holds_a_dash_is_not_taken_for_a_leg() -> None:
    domain = DomainSpec(name="d", version=1, says="d", route=(Route(start="bay-1", end="bay-2"), Route(start="bay-2", end="x")))
    trip = trip_of(event("blocked", "bay-1-bay-2"), graph_of(domain))
    assert trip.shut_legs == (("bay-1", "bay-2"),)


def test_an_event_that_blocks_a_place_without_naming_a_trip_asks_for_a_detour_across_it() -> None:
    trip = trip_of(event("object", "crate", route="blocking", context=Context(zone="hall")), GRAPH)
    assert trip == Trip(start="dock", goal="shelf", shut_nodes=("hall",), detour=True)
    assert ways(without(GRAPH, trip), "dock", "shelf", 1)[0].nodes == ("dock", "yard", "shelf")


def test_a_blocked_dead_end_can_only_be_given_up() -> None:
    trip = trip_of(event("blocked", "loft"), GRAPH)
    assert (trip.start, trip.goal) == ("shelf", "loft")
    assert ways(without(GRAPH, trip), trip.start, trip.goal, 1) == ()


def test_the_place_where_the_robot_stands_is_not_shut_to_it() -> None:
    trip = trip_of(event("blocked", "x", start="hall", goal="loft", location="hall"), GRAPH)
    assert trip.shut_nodes == ()


def test_an_event_that_blocks_nothing_has_no_detour() -> None:
    assert trip_of(event("object", "hall", state="normal"), GRAPH) == Trip()


def test_of_parallel_routes_the_cheapest_counts_and_costs_below_zero_count_as_nothing() -> None:
    domain = DomainSpec(
        name="d", version=1, says="d", route=(Route(start="a", end="b", cost=5.0), Route(start="b", end="a", cost=-2.0))
    )
    assert ways(graph_of(domain), "a", "b", 1)[0].cost == 0.0
