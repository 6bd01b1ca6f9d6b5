"""The route graph of a domain: what an event blocks in it, and the k cheapest ways that are left.

Source: k shortest simple paths, Yen 1971, as networkx has it.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from itertools import islice, pairwise
from typing import TypeAlias

import networkx as nx

from wakeful.facts.domain import DomainSpec
from wakeful.facts.events import Event
from wakeful.facts.values import Fact, Field
from wakeful.treatments.measures import number, significant

#: Fields that say where the robot is, where it should be, and what is shut.
_START = ("start", "from", "at", "node", "last_node", "position", "location")
_GOAL = ("goal", "to", "destination", "target", "end")
_SHUT = ("blocked", "blocked_edge", "blocked_node", "edge", "segment", "closed")

_ARROWS = ("->", "→", "--", "–", "|", "/", ",", ";", " to ", "-", "_")

Edge = tuple[str, str]
Graph: TypeAlias = "nx.DiGraph[str]"


class Way(Fact, frozen=True):
    """One way through the graph: its nodes, its cost, and the legs that it can't do without."""

    nodes: tuple[str, ...]
    cost: float
    depends_on: tuple[str, ...] = ()
    """Legs whose loss leaves no way at all."""


class Trip(Fact, frozen=True):
    """What the event says of the trip: from where, to where, and which nodes and legs are shut."""

    start: str = ""
    goal: str = ""
    shut_nodes: tuple[str, ...] = ()
    shut_legs: tuple[tuple[str, str], ...] = ()
    detour: bool = False
    """Start and goal were not told: they are the two ends of what is shut."""


def graph_of(domain: DomainSpec) -> Graph:
    """The domain's routes as a directed graph; of parallel legs the cheapest, costs below zero as zero."""
    graph: Graph = nx.DiGraph()
    for route in domain.route:
        cost = max(number(route.cost) or 0.0, 0.0)
        for start, end in ((route.start, route.end), (route.end, route.start))[: 2 if route.two_way else 1]:
            if not graph.has_edge(start, end) or graph.edges[start, end]["cost"] > cost:
                graph.add_edge(start, end, cost=cost)
    return graph


def trip_of(event: Event, graph: Graph) -> Trip:
    """Read the trip out of the event's fields, its context's, its entity and its zone. Names compare without regard to case."""
    names = {str(node).casefold(): str(node) for node in graph.nodes}
    fields: Mapping[str, Field] = {**event.context.fields, **event.fields}
    start, goal = _node(fields, _START, names), _node(fields, _GOAL, names)
    said = [fields[name] for name in _SHUT if isinstance(fields.get(name), str)]
    if any(word in event.kind for word in ("block", "obstacle", "closed")) or any(_is_shut(each) for each in fields.values()):
        said += [event.entity, fields.get("location"), event.context.zone]
    nodes: list[str] = []
    legs: list[Edge] = []
    for text in said:
        if not isinstance(text, str) or len(text) > 200:
            continue
        leg = _leg(text, names, graph)
        if leg is not None and leg not in legs:
            legs.append(leg)
        elif text.casefold() in names and names[text.casefold()] not in (*nodes, goal):
            nodes.append(names[text.casefold()])
    # where the robot stands can't be shut to it
    nodes = [node for node in nodes if node != start]
    detour = not (start and goal)
    if detour and legs:
        start, goal = legs[0]
    elif detour and nodes:
        start, goal = _across(graph, nodes[0])
    elif detour:
        return Trip(start=start, goal=goal)
    return Trip(start=start, goal=goal, shut_nodes=tuple(nodes), shut_legs=tuple(legs), detour=detour)


def without(graph: Graph, trip: Trip) -> Graph:
    """The graph without what the trip says is shut, a shut leg in both directions."""
    left: Graph = graph.copy()
    left.remove_nodes_from(trip.shut_nodes)
    left.remove_edges_from([leg for start, end in trip.shut_legs for leg in ((start, end), (end, start))])
    return left


def ways(graph: Graph, start: str, goal: str, count: int) -> tuple[Way, ...]:
    """The ``count`` cheapest simple ways, cheapest first; none where there is none. The first says what it depends on."""
    if start not in graph or goal not in graph or not nx.has_path(graph, start, goal):
        return ()
    found = [tuple(str(node) for node in nodes) for nodes in islice(nx.shortest_simple_paths(graph, start, goal, "cost"), count)]
    depends = _indispensable(graph, found[0])
    return tuple(Way(nodes=nodes, cost=cost_of(graph, nodes), depends_on=depends if nodes == found[0] else ()) for nodes in found)


def leg_name(leg: Edge) -> str:
    """A leg as a person reads it."""
    return f"{leg[0]}–{leg[1]}"


def impassable(graph: Graph, nodes: tuple[str, ...], trip: Trip) -> str:
    """Why a way cannot be driven on the graph; empty where it can."""
    if len(nodes) < 2 or (nodes[0], nodes[-1]) != (trip.start, trip.goal):
        return f"it does not lead from {trip.start} to {trip.goal}"
    if len(set(nodes)) < len(nodes):
        return "it passes a node twice"
    shut = next((leg for leg in pairwise(nodes) if not graph.has_edge(*leg)), None)
    return "" if shut is None else f"there is no free leg {leg_name(shut)}"


def cost_of(graph: Graph, nodes: Iterable[str]) -> float:
    """What a way costs."""
    at = list(nodes)
    return significant(sum(graph.edges[leg]["cost"] for leg in pairwise(at)))


def _indispensable(graph: Graph, nodes: tuple[str, ...]) -> tuple[str, ...]:
    found = []
    for leg in pairwise(nodes):
        left = nx.restricted_view(graph, [], [leg])
        if not nx.has_path(left, nodes[0], nodes[-1]):
            found.append(leg_name(leg))
    return tuple(found)


def _is_shut(value: Field) -> bool:
    return isinstance(value, str) and value.casefold() in ("blocked", "blocking", "closed")


def _node(fields: Mapping[str, Field], names: tuple[str, ...], nodes: Mapping[str, str]) -> str:
    for name in names:
        value = fields.get(name)
        if isinstance(value, str) and value.casefold() in nodes:
            return nodes[value.casefold()]
    return ""


def _leg(text: str, names: Mapping[str, str], graph: Graph) -> Edge | None:
    folded = text.casefold()
    for arrow in _ARROWS:
        # a node's own name may contain the arrow, so every place to cut is tried
        at = folded.find(arrow)
        while at >= 0:
            start, end = names.get(folded[:at].strip()), names.get(folded[at + len(arrow) :].strip())
            if start is not None and end is not None and (graph.has_edge(start, end) or graph.has_edge(end, start)):
                return (start, end) if graph.has_edge(start, end) else (end, start)
            at = folded.find(arrow, at + 1)
    return None


def _across(graph: Graph, node: str) -> Edge:
    """The neighbours between which the shut node is the cheapest way through, so that a detour replaces it."""
    into = sorted((float(graph.edges[before, node]["cost"]), str(before)) for before in graph.predecessors(node))
    out = sorted((float(graph.edges[node, after]["cost"]), str(after)) for after in graph.successors(node))
    pairs = [(a + b, start, goal) for a, start in into for b, goal in out if start != goal]
    if pairs:
        return min(pairs)[1:]
    # a dead end: nothing leads through it, so what is lost is the node itself
    return (into[0][1], node) if into else ("", "")
