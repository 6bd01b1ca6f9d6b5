"""How long treatments may think between two looks at what came: by the time that their own code took before."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import overload

from wakeful.facts.crashes import Page
from wakeful.facts.inputs import Input, Requests
from wakeful.kernel import Kernel

#: For about so long treatments think before the driver looks whether something came. Where steps are slow that is one at a time,
#: so that a treatment is preempted at its next await.
TURN_S = 0.002

#: With each input they may think so much longer: about what the rest of the kernel does for one takes anyway.
PER_INPUT_S = 200e-6

#: Where there is a backlog a turn takes about so long at most, with all that the kernel does for its steps.
BACKLOG_S = 0.01

#: A step of less is quick: the kernel does more for it than the treatment.
QUICK_S = 100e-6

#: What is thought of a step before one was measured. It may be little: a turn ends early where they take longer.
_AT_FIRST_S = 20e-6
_LEAST_S = 1e-7

#: At most so many steps, however short they were.
MOST_STEPS = 4096


class Stopwatch:
    """A page that says whose treatment is running, and measures for how long treatments' own code ran.

    Args:
        page: where whose treatment is running is said.
        clock_s: the time that is measured by.
        over: called between two treatments' turns once their time is up.
    """

    __slots__ = ("_allowed_s", "_began_s", "_clock_s", "_over", "_page", "ran_s")

    def __init__(self, page: Page, clock_s: Callable[[], float], over: Callable[[], None]) -> None:
        self._page = page
        self._clock_s = clock_s
        self._over = over
        self._began_s = 0.0
        self._allowed_s = TURN_S
        self.ran_s = 0.0

    @overload
    def __setitem__(self, place: int, value: int, /) -> None: ...
    @overload
    def __setitem__(self, place: slice, value: bytes, /) -> None: ...
    def __setitem__(self, place: int | slice, value: int | bytes, /) -> None:
        """A treatment's code begins to run (a slice), or has run (its first byte)."""
        self._page[place] = value  # type: ignore[index, assignment]
        if place.__class__ is slice:
            self._began_s = self._clock_s()
        else:
            self.ran_s += self._clock_s() - self._began_s
            if self.ran_s > self._allowed_s:
                self._over()

    def begin(self, allowed_s: float) -> None:
        """A turn begins, in which they may run for so long."""
        self.ran_s = 0.0
        self._allowed_s = allowed_s


class Turns:
    """Feeds a kernel, giving treatments as many steps as fit into a turn.

    What counts is how long treatments' own code takes, for the rest is the input's; where there is a backlog, also how long a
    step takes with all that the kernel does for it. No further step is begun once treatments' code has run for longer than was
    thought.

    Args:
        kernel: recovered.
        page: where the kernel says whose treatment is running.
        clock_s: the time that is measured by.
    """

    def __init__(self, kernel: Kernel, page: Page, clock_s: Callable[[], float]) -> None:
        self._kernel = kernel
        self._clock_s = clock_s
        self._watch = Stopwatch(page, clock_s, kernel.enough)
        self._own_s = self._whole_s = _AT_FIRST_S
        kernel.mark_on(self._watch)

    @property
    def quick(self) -> bool:
        """Whether it is not the treatments' own code that takes the time."""
        return self._own_s < QUICK_S

    def feed(self, inputs: Sequence[Input], now_ns: int, hold: bool = False) -> Requests:
        """The kernel's ``feed``, with as many steps as fit."""
        kernel, watch = self._kernel, self._watch
        allowed_s = TURN_S + PER_INPUT_S * len(inputs)
        steps = min(MOST_STEPS, int(allowed_s / self._own_s))
        if kernel.runnable:
            steps = min(steps, int(BACKLOG_S / self._whole_s))
        done, began_s = kernel.steps_done, self._clock_s()
        watch.begin(allowed_s)
        requests = kernel.feed(inputs, now_ns, max(1, steps), hold)
        done = kernel.steps_done - done
        if done:
            self._own_s = _eased(self._own_s, watch.ran_s / done)
            if not inputs:
                self._whole_s = _eased(self._whole_s, (self._clock_s() - began_s) / done)
        return requests


def _eased(before_s: float, took_s: float) -> float:
    """A slow step counts at once, quick ones little by little."""
    return took_s if took_s > before_s else max(_LEAST_S, 0.75 * before_s + 0.25 * took_s)
