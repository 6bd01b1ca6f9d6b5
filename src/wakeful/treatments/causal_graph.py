"""The domain's causal graph over event kinds and outcome labels: chains into an event, and what could confound them.

An arrow is identified from what was seen only if no common cause of both ends stands open (the back-door criterion, Pearl 1995).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TypeAlias

import networkx as nx

from wakeful.facts.domain import Cause, DomainSpec
from wakeful.facts.values import Fact
from wakeful.treatments.measures import number

Graph: TypeAlias = "nx.DiGraph[str]"


class Arrow(Fact, frozen=True):
    """One arrow with finite numbers: strength in [0, 1], delay above zero."""

    cause: str
    effect: str
    within_s: float
    strength: float
    because: str = ""


def arrows_of(domain: DomainSpec) -> tuple[Arrow, ...]:
    """The usable arrows of the domain: those without a delay above zero, or from a kind to itself, say nothing."""
    return tuple(_arrow(each) for each in domain.cause if (number(each.within_s) or 0.0) > 0.0 and each.cause != each.effect)


def into(arrows: Sequence[Arrow], effect: str) -> tuple[Arrow, ...]:
    """The arrows that end in ``effect``, strongest first."""
    return tuple(sorted((a for a in arrows if a.effect == effect), key=lambda a: (-a.strength, a.cause)))


def out_of(arrows: Sequence[Arrow], cause: str) -> tuple[Arrow, ...]:
    """The arrows that begin in ``cause``, strongest first."""
    return tuple(sorted((a for a in arrows if a.cause == cause), key=lambda a: (-a.strength, a.effect)))


def chains(arrows: Sequence[Arrow], effect: str, depth: int) -> Iterator[tuple[Arrow, ...]]:
    """Chains of at most ``depth`` arrows that lead to ``effect``, the last arrow first, shorter ones first; none in circles."""
    level: list[tuple[Arrow, ...]] = [(arrow,) for arrow in into(arrows, effect)]
    for _ in range(depth):
        yield from level
        level = [
            (*chain, arrow)
            for chain in level
            for arrow in into(arrows, chain[-1].cause)
            if arrow.cause != effect and all(arrow.cause != link.cause for link in chain)
        ]


def confounders(arrows: Sequence[Arrow], cause: str, effect: str) -> tuple[str, ...]:
    """Common causes of both ends whose way to the effect does not pass through ``cause``: while they are open, what is seen
    together does not tell what would happen if the cause were taken away."""
    graph: Graph = nx.DiGraph([(arrow.cause, arrow.effect) for arrow in arrows])
    if cause not in graph or effect not in graph:
        return ()
    around = nx.restricted_view(graph, [cause], [])
    common = set(nx.ancestors(graph, cause)) & set(nx.ancestors(around, effect))
    return tuple(sorted(str(name) for name in common))


def _arrow(cause: Cause) -> Arrow:
    strength = min(max(number(cause.strength) or 0.0, 0.0), 1.0)
    return Arrow(cause=cause.cause, effect=cause.effect, within_s=float(cause.within_s), strength=strength, because=cause.because)
