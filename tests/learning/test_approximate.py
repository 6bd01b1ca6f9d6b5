"""Above the limit of the exact search: the index finds nearly all true neighbours, and what is wanted of them is exact."""

from __future__ import annotations

import numpy as np
import pytest

from wakeful.contracts.learner import Vector
from wakeful.facts.asking import Query
from wakeful.facts.events import Event
from wakeful.facts.lines import Admitted, Concluded
from wakeful.facts.time import Stamp
from wakeful.facts.values import Raw
from wakeful.learning.episodes import Episodes

pytest.importorskip("usearch")

RANDOM = np.random.default_rng(3)
ROWS = RANDOM.random((1200, 12))


def encode(event: Event) -> Vector:
    return ROWS[event.position]


def filled(exact: int, limit: int = 10_000) -> Episodes:
    episodes = Episodes(encode, limit, exact)
    for number in range(len(ROWS)):
        stamp = Stamp(source_ns=number, received_ns=number)
        kind = "odd" if number % 2 else "even"
        event = Event(id=f"e{number}", kind=kind, entity=f"t{number % 9}", source="s", position=number, stamp=stamp)
        episodes.apply(Admitted(event=event))
        result = Raw(b'{"says":"so"}')
        episodes.apply(Concluded(process=number + 1, event=event.id, treatment="memory", mode="auto", result=result))
    return episodes


def test_nearly_every_true_neighbour_is_found_in_the_order_of_its_distance() -> None:
    exact, near = filled(exact=10_000), filled(exact=100)
    shared = 0
    for number in range(0, 1200, 12):
        query = Query(event=f"e{number}", limit=5)
        true, found = exact.search(query, 10**9), near.search(query, 10**9)
        assert [each.likeness for each in found] == sorted((each.likeness for each in found), reverse=True)
        shared += len({each.event for each in true} & {each.event for each in found})
    assert shared >= 0.95 * 500


def test_a_search_that_the_index_cannot_serve_is_exact() -> None:
    exact, near = filled(exact=10_000), filled(exact=100)
    query = Query(event="e7", kind="odd", entity="t7", limit=20)
    assert near.search(query, 10**9) == exact.search(query, 10**9)


def test_what_is_forgotten_is_not_found_and_the_index_is_built_anew() -> None:
    episodes = filled(exact=100, limit=1000)
    found = episodes.search(Query(event="e1199", limit=10), 10**9)
    assert len(found) == 10
    assert all(int(each.event[1:]) > 200 for each in found)
