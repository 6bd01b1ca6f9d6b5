"""How long a turn lasts: by the time that treatments' own code took, not by what else there was to do."""

from __future__ import annotations

from collections.abc import Sequence

from wakeful.drivers.turn import MOST_STEPS, QUICK_S, TURN_S, Turns
from wakeful.facts.crashes import MARKED, Page, mark
from wakeful.facts.inputs import Input, Mark, Requests


class Clock:
    """Stands still until somebody works."""

    now_s = 0.0

    def __call__(self) -> float:
        return self.now_s


class Treating:
    """Stands in for a kernel: so many steps are due, each of so much of its treatment's own time, each input of so much other."""

    def __init__(self, clock: Clock, runnable: int, own_s: float, other_s: float = 0.0) -> None:
        self.clock = clock
        self.runnable = runnable
        self.own_s = own_s
        self.other_s = other_s
        self.steps_done = 0
        self.page: Page = bytearray(MARKED)
        self.stopped = False

    def mark_on(self, page: Page) -> None:
        self.page = page

    def enough(self) -> None:
        self.stopped = True

    def feed(self, inputs: Sequence[Input], now_ns: int, steps: int, hold: bool) -> Requests:
        self.clock.now_s += self.other_s * len(inputs)
        self.stopped = False
        while self.runnable and steps and not self.stopped and not hold:
            mark(self.page, "event")
            self.clock.now_s += self.own_s
            self.page[0] = 0
            steps -= 1
            self.runnable -= 1
            self.steps_done += 1
        return Requests()


def turns(kernel: Treating) -> Turns:
    return Turns(kernel, bytearray(MARKED), kernel.clock)  # type: ignore[arg-type]  # all of it that turns know


def test_a_turn_of_slow_steps_ends_after_the_first_that_takes_too_long() -> None:
    kernel = Treating(Clock(), 100, own_s=2 * TURN_S)
    turn = turns(kernel)
    for done in (1, 2, 3):
        turn.feed((), 0)
        assert kernel.steps_done == done
    assert not turn.quick


def test_steps_that_become_slow_are_fewer_from_the_next_turn_on() -> None:
    kernel = Treating(Clock(), 10_000, own_s=TURN_S / 50)
    turn = turns(kernel)
    turn.feed((), 0)
    before = kernel.steps_done
    assert before >= 50
    kernel.own_s = TURN_S / 4
    turn.feed((), 0)
    turn.feed((), 0)
    assert kernel.steps_done - before <= 10


def test_the_time_that_inputs_take_does_not_count_as_that_of_steps() -> None:
    clock = Clock()
    kernel = Treating(clock, 0, own_s=1e-6, other_s=300e-6)
    turn = turns(kernel)
    for _ in range(10):
        kernel.runnable = 0
        inputs = [Mark("s", number) for number in range(100)]
        before = kernel.steps_done
        feed = kernel.feed

        def arriving(inputs: Sequence[Input], now_ns: int, steps: int, hold: bool) -> Requests:
            kernel.runnable = 3 * len(inputs)  # each brings three steps
            return feed(inputs, now_ns, steps, hold)  # noqa: B023

        kernel.feed = arriving  # type: ignore[method-assign]
        turn.feed(inputs, 0)
        kernel.feed = feed  # type: ignore[method-assign]
        assert kernel.steps_done - before == 300  # all of them, though the feed took 30 ms
    assert turn.quick


def test_there_is_an_end_to_quick_steps_too() -> None:
    kernel = Treating(Clock(), 3 * MOST_STEPS, own_s=QUICK_S / 1e6)
    turn = turns(kernel)
    turn.feed([Mark("s", number) for number in range(1_000)], 0)
    assert 0 < kernel.steps_done <= MOST_STEPS
