"""Workload W: what its docs say of it is so."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.peers.lean import features
from benchmarks.peers.messages import Event, Evidence, Outcome, Tick, decode
from benchmarks.peers.treating import LIMIT_NS, WAITS, checksum, conclude, look, verdict, weigh
from benchmarks.peers.workload import Workload, make
from wakeful.validation.verdict import verdict as wakefuls_verdict

EVENTS = 1000


@pytest.fixture(scope="module")
def workload() -> Workload:
    return make(3, EVENTS)


def test_the_same_seed_gives_the_same_messages_and_another_seed_others() -> None:
    first, again, other = make(5, 40), make(5, 40), make(6, 40)
    assert first.messages == again.messages
    assert first.facts == again.facts
    assert first.weights == again.weights
    assert first.messages != other.messages
    assert first.facts.checksum != other.facts.checksum


def test_a_fifth_waits_and_of_these_three_percent_are_read_early_two_twice_and_five_never(workload: Workload) -> None:
    messages = [decode(text) for text in workload.messages]
    events = {message.entity: message for message in messages if isinstance(message, Event)}
    waiting = {entity for entity, event in events.items() if event.category == WAITS}
    readings = [message for message in messages if isinstance(message, Evidence)]
    read = [message.entity for message in readings if message.entity in waiting]
    assert len(events) == EVENTS
    assert len(waiting) == EVENTS // 5 == len(readings) == workload.facts.evidence
    assert len(waiting - set(read)) == 10
    assert len(read) - len(set(read)) == 4
    assert len({each.entity for each in readings if each.at_ns < events[each.entity].at_ns}) == 6


def test_every_event_has_one_outcome_after_its_limit_has_passed(workload: Workload) -> None:
    messages = [decode(text) for text in workload.messages]
    came = {message.entity: message.at_ns for message in messages if isinstance(message, Event)}
    outcomes = [message for message in messages if isinstance(message, Outcome)]
    assert sorted(message.entity for message in outcomes) == sorted(came)
    assert all(message.at_ns > came[message.entity] + LIMIT_NS for message in outcomes)


def test_messages_come_in_order_of_time_and_ticks_go_on_beyond_the_last_limit(workload: Workload) -> None:
    messages = [decode(text) for text in workload.messages]
    assert [message.at_ns for message in messages] == sorted(message.at_ns for message in messages)
    last = max(message.at_ns for message in messages if isinstance(message, Event))
    assert isinstance(messages[-1], Tick)
    assert messages[-1].at_ns > last + LIMIT_NS


def test_an_event_with_a_value_out_of_range_is_not_decoded(workload: Workload) -> None:
    text = next(each for each in workload.messages if b'"is":"event"' in each)
    decode(text)
    with pytest.raises(ValueError, match="load"):
        decode(text.replace(b'"load":', b'"load":7'))


def test_the_model_decides_between_all_treatments(workload: Workload) -> None:
    events = [message for message in map(decode, workload.messages) if isinstance(message, Event)]
    names = {name for name, _ in workload.lean.choose(events)}
    assert len(names) >= 5
    assert {label for _, label in workload.lean.choose(events)} == {"none", "intervention"}


def test_features_are_five_categories_and_three_numbers(workload: Workload) -> None:
    events = [message for message in map(decode, workload.messages) if isinstance(message, Event)][:7]
    rows = features(events)
    assert rows.shape == (7, 20)
    assert np.array_equal(rows[:, :17].sum(axis=1), np.full(7, 5.0))
    assert rows[0, -3:].tolist() == [events[0].load, events[0].x, events[0].y]


def test_the_checksum_is_of_the_set_and_of_each_line() -> None:
    assert checksum(["a", "b"]) == checksum(["b", "a"])
    assert checksum(["a", "b"]) != checksum(["a", "c"])
    assert checksum(["a", "b"]) != checksum(["a"])


def test_each_step_of_the_stub_changes_what_is_concluded() -> None:
    assert look("a", 0.1) != look("b", 0.1)
    assert look("a", 0.1) != look("a", 0.2)
    assert weigh(1, None) != weigh(1, 3.0) != weigh(1, 3.1)
    assert conclude(1, "none") != conclude(1, "intervention")


@pytest.mark.parametrize("predicted", ["none", "intervention"])
@pytest.mark.parametrize("label", ["none", "intervention"])
@pytest.mark.parametrize("acted_on", [False, True])
def test_the_verdict_is_by_wakefuls_rule(predicted: str, label: str, acted_on: bool) -> None:
    assert verdict(predicted, label, acted_on) == wakefuls_verdict(predicted, label, acted_on).value
