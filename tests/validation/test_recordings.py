"""What is known of recordings: clocks are put right, ends and gaps make silence say nothing."""

from __future__ import annotations

import pytest

from wakeful.facts.evidence import Outcome
from wakeful.validation.ledger import Entry
from wakeful.validation.recordings import ENDED, Recordings


def entry(source: str = "a", heard_all: bool = True) -> Entry:
    return Entry(
        process=1,
        event="e1",
        treatment="diagnosis",
        mode="auto",
        label="none",
        topic="outcome",
        entity="gripper",
        robot="",
        source=source,
        since_ns=100,
        until_ns=200,
        closes_ns=200,
        concluded_ns=110,
        heard_all=heard_all,
    )


def outcome(source: str, at_ns: int, event: str = "") -> Outcome:
    return Outcome(id="o", topic="outcome", entity="gripper", label="stop", at_ns=at_ns, source=source, event=event)


def test_an_outcome_is_taken_to_kernel_time_by_its_own_recording() -> None:
    recordings = Recordings()
    recordings.opened("a", 1_000)
    assert recordings.in_kernel_time(outcome("a", 5)).at_ns == 1_005
    assert recordings.in_kernel_time(outcome("b", 5)).at_ns == 5


def test_another_recording_that_began_after_the_end_does_not_speak_of_it() -> None:
    recordings = Recordings()
    recordings.ended("a", 150)
    assert not recordings.reaches(outcome("b", 160), entry())
    assert recordings.reaches(outcome("b", 140), entry())
    assert recordings.reaches(outcome("b", 160, event="e1"), entry())


def test_a_recording_that_is_opened_again_has_not_ended() -> None:
    recordings = Recordings()
    recordings.ended("a", 150)
    recordings.opened("a", 0)
    assert recordings.reaches(outcome("b", 160), entry())
    assert recordings.doubt(entry()) == ""


@pytest.mark.parametrize(
    ("ended", "broken", "heard_all", "doubted"), [(150, 0, True, ENDED), (0, 150, True, "gap"), (0, 0, False, "no longer")]
)
def test_silence_over_a_window_that_was_not_whole_says_nothing(ended: int, broken: int, heard_all: bool, doubted: str) -> None:
    recordings = Recordings()
    if ended:
        recordings.ended("a", ended)
    if broken:
        recordings.broken("a", broken)
    assert doubted in recordings.doubt(entry(heard_all=heard_all))
    assert recordings.doubt(entry(source="b")) == ""
