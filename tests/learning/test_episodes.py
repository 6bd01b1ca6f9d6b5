"""Episodic memory."""

from __future__ import annotations

import msgspec
import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.learning.worlds import event, experience
from wakeful.contracts.learner import Vector
from wakeful.facts.asking import Query
from wakeful.facts.events import Event
from wakeful.facts.experience import Verdict
from wakeful.facts.lines import Admitted, Concluded, Created, Gained, Judged
from wakeful.facts.results import Forecast
from wakeful.learning.episodes import Episodes

LATER = 10**18


def encode(of: Event) -> Vector:
    load = of.fields["load"]
    assert isinstance(load, float)
    return np.array([load, float(of.kind == "k"), 0.5])


def concluded(of: Event, process: int = 0, says: str = "It will stop.", label: str = "stop") -> Concluded:
    return Concluded(
        process=process or of.position,
        event=of.id,
        treatment="diagnosis",
        mode="auto",
        result=msgspec.Raw(msgspec.json.encode({"type": "diagnosed", "says": says, "confidence": 0.5})),
        forecast=Forecast(label=label, probability=0.7),
    )


def remember(into: Episodes, of: Event, experience_id: int = 0) -> None:
    into.apply(Admitted(event=of))
    into.apply(concluded(of))
    if experience_id:
        into.apply(Gained(experience=experience(experience_id, of)))


def test_an_episode_says_what_it_was_what_was_concluded_and_how_it_ended() -> None:
    one, of = Episodes(encode), event(1, load=0.25)
    remember(one, of, 4)
    one.apply(Judged(process=1, event="e1", predicted="stop", label="none", verdict=Verdict.CONTRADICTED))
    one.apply(Admitted(event=event(2, load=0.25)))
    (episode,) = one.search(Query(event="e2"), LATER)
    assert (episode.event, episode.treatment, episode.says, episode.predicted) == ("e1", "diagnosis", "It will stop.", "stop")
    assert (episode.outcome, episode.verdict, episode.experience, episode.likeness) == ("none", "contradicted", 4, 1.0)
    assert episode.fields == {"load": 0.25}


def test_what_is_not_concluded_and_the_event_itself_are_not_recalled() -> None:
    one = Episodes(encode)
    remember(one, event(1))
    one.apply(Admitted(event=event(2)))
    assert [episode.event for episode in one.search(Query(event="e1"), LATER)] == []
    assert [episode.event for episode in one.search(Query(event="e2"), LATER)] == ["e1"]


def test_a_childs_conclusion_is_not_the_events() -> None:
    one = Episodes(encode)
    one.apply(Admitted(event=event(1)))
    one.apply(Created(process=7, event="e1", treatment="memory", criticality=0, parent=1))
    one.apply(concluded(event(1), process=7, says="the child's"))
    assert one.search(Query(), LATER) == ()
    one.apply(concluded(event(1), process=1, says="its own"))
    assert one.search(Query(), LATER)[0].says == "its own"


def test_an_undecided_verdict_does_not_hide_a_decided_one() -> None:
    one = Episodes(encode)
    remember(one, event(1))
    one.apply(Judged(process=1, event="e1", predicted="stop", label="stop", verdict=Verdict.SUPPORTED))
    one.apply(Judged(process=1, event="e1", predicted="stop", label="", verdict=Verdict.UNDECIDED))
    assert one.search(Query(), LATER)[0].verdict == "supported"


def test_equal_likeness_goes_by_newest() -> None:
    one = Episodes(encode)
    for number in range(1, 200):
        remember(one, event(number, load=0.5), number)
    assert one.nearest(np.array([0.5, 1.0, 0.5]), 3) == (199, 198, 197)
    assert [episode.event for episode in one.search(Query(event="e50", limit=2), LATER)] == ["e199", "e198"]


def test_a_query_is_confined_to_its_entity_and_kind_and_to_the_past() -> None:
    one = Episodes(encode)
    remember(one, event(1, entity="a"))
    remember(one, event(2, entity="b", kind="other"))
    remember(one, event(3, entity="a", kind="other"))
    found = [episode.event for episode in one.search(Query(entity="a"), LATER)]
    assert found == ["e3", "e1"]
    assert [episode.event for episode in one.search(Query(entity="a", kind="other"), LATER)] == ["e3"]
    assert [episode.event for episode in one.search(Query(entity="a"), now_ns=2 * 10**9)] == ["e1"]
    assert one.search(Query(limit=0), LATER) == ()


def test_past_its_limit_the_oldest_are_forgotten_and_the_rest_stay_right() -> None:
    one = Episodes(encode, limit=50)
    for number in range(1, 173):
        remember(one, event(number, load=number / 200), number)
        assert len(one) <= 50
    assert one.nearest(np.array([171 / 200, 1.0, 0.5]), 1) == (171,)
    one.apply(Judged(process=1, event="e1", predicted="", label="none", verdict=Verdict.SUPPORTED))
    assert one.search(Query(event="e1", limit=1), LATER)[0].event == "e172"


@settings(max_examples=50, deadline=None)
@given(
    st.lists(st.sampled_from([0.0, 0.1, 0.1000001, 0.5, 0.9]), min_size=1, max_size=80),
    st.sampled_from([0.0, 0.1, 0.4, 1.0]),
    st.integers(1, 9),
)
def test_the_nearest_are_those_of_an_exact_search(loads: list[float], at: float, k: int) -> None:
    one = Episodes(encode, limit=64)
    for number, load in enumerate(loads, 1):
        remember(one, event(number, load=load), number if number % 3 else 0)
    kept = [(number, load) for number, load in enumerate(loads, 1) if number > len(loads) - len(one) and number % 3]
    exact = sorted(kept, key=lambda pair: (round(abs(float(np.float32(pair[1])) - float(np.float32(at))), 6), -pair[0]))
    assert one.nearest(np.array([at, 1.0, 0.5]), k) == tuple(number for number, _ in exact[:k])


def test_after_forgetting_a_query_still_finds_its_entity() -> None:
    one = Episodes(encode, limit=20)
    for number in range(1, 60):
        remember(one, event(number, entity=f"thing {number % 3}", kind="k" if number % 2 else "other"))
    found = [episode.event for episode in one.search(Query(entity="thing 1", kind="k", limit=3), LATER)]
    assert found == ["e55", "e49", "e43"]
    assert one.search(Query(entity="thing 9"), LATER) == ()


@settings(max_examples=30, deadline=None)
@given(before=st.integers(0, 40), folded=st.integers(0, 200), limit=st.integers(2, 60))
def test_what_is_folded_in_a_hurry_is_recalled_as_if_it_had_been_told_one_by_one(before: int, folded: int, limit: int) -> None:
    written = 0

    def counting(events: list[Event]) -> Vector:
        nonlocal written
        written += len(events)
        return np.array([encode(of) for of in events])

    calm, hurried = Episodes(encode, limit=limit), Episodes(encode, limit=limit, encode_many=counting)
    for one in (calm, hurried):
        for number in range(before):
            remember(one, event(number, load=number % 7 / 7))
        one.search(Query(limit=1), LATER)
        if one is hurried:
            one.hurry(True)
        for number in range(before, before + folded):
            remember(one, event(number, load=number % 7 / 7))
        if one is hurried:
            one.hurry(False)
    query = Query(event=f"e{before + folded - 1}", limit=8)
    assert hurried.search(query, LATER) == calm.search(query, LATER)
    assert written <= before + limit
