"""A topic that falls silent, told by the others."""

from __future__ import annotations

from tests.registration.watching import detector, seen
from wakeful.contracts.detector import Detector, Found
from wakeful.facts.events import Observation, Phase


def heard(watcher: Detector, observations: list[Observation]) -> list[tuple[int, object, Phase | None]]:
    return [
        (each.position, item.fields.get("topic"), item.phase)
        for each in observations
        for item in watcher.observe(each)
        if isinstance(item, Found)
    ]


def test_a_silent_topic_is_noticed_by_the_time_that_others_tell() -> None:
    stream, position = [], 0
    for step in range(100):
        stream.append(seen(position, step * 0.1, "clock"))
        position += 1
        if step < 50 or step > 80:
            stream.append(seen(position, step * 0.1 + 0.01, "scan"))
            position += 1
    found = heard(detector("silence", ("scan/*",), "{topic}", least_s=0.5), stream)
    assert [(topic, phase) for _, topic, phase in found] == [("scan", Phase.RAISED), ("scan", Phase.CLEARED)]
    raised = next(each for each in stream if each.position == found[0][0])
    assert 5.3 < raised.at_ns / 1e9 < 5.7


def test_a_single_topic_notices_its_own_gap_when_it_is_back() -> None:
    stream = [seen(step, float(step)) for step in range(50)] + [seen(50, 500.0)]
    found = heard(detector("silence", ("*",)), stream)
    assert [(position, phase) for position, _, phase in found] == [(50, Phase.RAISED), (50, Phase.CLEARED)]


def test_an_irregular_topic_is_never_silent() -> None:
    at_s, stream = 0.0, []
    for step in range(200):
        at_s += 100.0 if step % 25 == 0 else 0.01
        stream.append(seen(step, at_s))
    # the first silence or two are news; then the topic is known to be so
    assert len(heard(detector("silence", ("*",), steady=1.5), stream)) <= 4


def test_a_clock_set_back_is_no_silence() -> None:
    stream = [seen(step, 10_000.0 + step) for step in range(50)] + [seen(50 + step, float(step)) for step in range(50)]
    assert heard(detector("silence", ("*",)), stream) == []
