"""Recall counts what came before an incident, and what chance would have reached."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from wakeful.facts.evidence import Outcome
from wakeful.registration import Incident, incidents_of, recall

S = 1_000_000_000


def test_an_event_at_or_after_an_incident_never_counts_for_it() -> None:
    (found,) = recall([Incident(label="stop", at_ns=10 * S)], [10 * S, 11 * S], 5.0)
    assert (found.preceded, found.share, found.lead_s) == (0, 0.0, None)


def test_the_window_is_closed_at_its_far_end() -> None:
    stop = [Incident(label="stop", at_ns=10 * S)]
    assert recall(stop, [5 * S], 5.0)[0].preceded == 1
    assert recall(stop, [5 * S - 1], 5.0)[0].preceded == 0


def test_each_label_stands_for_itself_and_long_incidents_weigh_by_their_observations() -> None:
    incidents = [
        Incident(label="a", at_ns=10 * S, observations=9),
        Incident(label="b", at_ns=20 * S),
        Incident(label="a", at_ns=90 * S),
    ]
    first, second = recall(incidents, [9 * S, 7 * S, 85 * S], 4.0)
    assert (first.label, first.incidents, first.share, first.observations_share) == ("a", 2, 0.5, 0.9)
    assert first.lead_s == (3.0, 3.0, 3.0)
    assert (second.label, second.share) == ("b", 0.0)


def test_without_events_chance_is_nothing_and_with_very_many_it_is_certain() -> None:
    stop = [Incident(label="stop", at_ns=10 * S)]
    assert recall(stop, [], 5.0, observed_s=100.0)[0].chance == 0.0
    many = recall(stop, list(range(0, 100 * S, S // 10)), 5.0, observed_s=100.0)[0]
    assert many.chance is not None
    assert many.chance > 0.999


@given(st.lists(st.integers(0, 200), min_size=1, max_size=30), st.lists(st.integers(0, 200), max_size=30), st.integers(1, 50))
def test_a_wider_window_never_hears_less(incidents: list[int], events: list[int], window_s: int) -> None:
    known = [Incident(label="x", at_ns=at * S) for at in incidents]
    narrow, wide = (recall(known, [at * S for at in events], float(width))[0].preceded for width in (window_s, window_s + 10))
    assert narrow <= wide


def test_incidents_of_outcomes_come_in_order() -> None:
    outcomes = [Outcome(id=str(at), topic="outcome", entity="*", label="stop", at_ns=at) for at in (30, 10)]
    assert [incident.at_ns for incident in incidents_of(outcomes)] == [10, 30]
