"""What is learned of effort: by kind, from completed processes, whatever the order it is told in."""

from __future__ import annotations

import msgspec

from tests.scheduling.policies.views import seen
from wakeful.facts.time import NS_PER_S
from wakeful.scheduling.policies.effort import STEP, Effort, History


def test_what_is_assumed_gives_way_to_what_was_seen() -> None:
    effort = Effort(None, 4)
    assert effort.left(0) == 4 * STEP
    assert effort.left(1) == 3 * STEP
    for _ in range(50):
        effort.completed(7, None)
    assert abs(effort.left(0) - 7 * STEP) < 100
    assert effort.least_left(2) == 5 * STEP


def test_what_is_left_is_the_mean_of_those_that_took_longer_than_this_one_has() -> None:
    effort = Effort(None, 4)
    for steps in (2, 2, 2, 8, 8):
        effort.completed(steps, None)
    assert effort.left(0) < 6 * STEP
    assert effort.left(3) > 4 * STEP


def test_there_is_always_at_least_one_step_left() -> None:
    effort = Effort(None, 4)
    effort.completed(3, None)
    assert effort.left(10) == STEP
    assert effort.least_left(10) == STEP


def test_an_unknown_kind_is_taken_for_the_mean_of_all() -> None:
    history = History(4)
    for number in range(9):
        history.completed(seen(number, done=9, kind="known"), None, number)
    history.advance(100)
    assert history.of(seen(50, kind="unknown")).left(0) > 8 * STEP


def test_whether_a_kind_waits_is_what_most_of_it_did_and_without_experience_it_does() -> None:
    effort = Effort(None, 4)
    assert effort.likely_waits()
    effort.completed(3, None)
    assert not effort.likely_waits()
    effort.waits()
    assert effort.likely_waits()


def test_what_follows_a_wait_is_learned_apart() -> None:
    effort = Effort(None, 4)
    for _ in range(20):
        effort.waits()
        effort.completed(6, 5)
    assert effort.left_after_wait(5) == STEP
    assert effort.left(0) > 5 * STEP


def test_the_longest_wait_is_counted_from_the_beginning_of_the_process() -> None:
    history = History(4)
    assert history.of(seen(1)).longest_wait_ns is None
    history.woke(seen(1, started_s=2), 12 * NS_PER_S)
    history.woke(seen(2, started_s=5), 9 * NS_PER_S)
    history.advance(20 * NS_PER_S)
    assert history.of(seen(3)).longest_wait_ns == 10 * NS_PER_S
    assert history.of(seen(3, kind="other")).longest_wait_ns == 10 * NS_PER_S


def test_what_is_told_at_an_instant_counts_from_the_next_one_on() -> None:
    history = History(4)
    history.completed(seen(1, done=9), None, 5)
    history.advance(5)
    assert history.of(seen(2)).left(0) == 4 * STEP
    history.advance(6)
    assert history.of(seen(2)).left(0) > 4 * STEP


def test_how_long_a_step_takes_is_the_time_that_completed_processes_held_a_slot_over_their_steps() -> None:
    history = History(4)
    assert history.step_ns == 0
    history.completed(msgspec.structs.replace(seen(1, done=4), spent_ns=8 * NS_PER_S), None, 1)
    history.completed(msgspec.structs.replace(seen(2, done=4), spent_ns=4 * NS_PER_S), None, 1)
    history.advance(2)
    assert history.step_ns == 12 * NS_PER_S // 8
