"""Evidence is taken up in the order of decision, whatever the order of outcomes."""

from __future__ import annotations

from random import Random

from wakeful.selection.guarantee.in_order import InOrder, Waiting


def waiting(process: int) -> Waiting:
    return Waiting(
        process=process,
        event=f"event {process}",
        number=1,
        treatment="memory",
        predicted="none",
        place=0,
        automatic=True,
        probability=1.0,
        drawn=True,
        mode="auto",
        ran=True,
    )


def test_an_outcome_waits_for_those_of_the_events_before_it() -> None:
    queue = InOrder()
    first, second, third = waiting(1), waiting(2), waiting(3)
    for each in (first, second, third):
        queue.add(each)
    second.settled = True
    assert list(queue.ready()) == []
    first.settled = True
    assert list(queue.ready()) == [first, second]
    third.settled = True
    assert list(queue.ready()) == [third]
    assert len(queue) == 0
    assert queue.longest == 3


def test_every_event_comes_out_once_and_in_order_for_any_order_of_outcomes() -> None:
    queue, events, out = InOrder(), [waiting(number) for number in range(200)], []
    for each in events:
        queue.add(each)
    for each in Random(0).sample(events, len(events)):
        each.settled = True
        out += list(queue.ready())
    assert out == events
