"""How much effort processes take, learned from those that were completed: for a policy whose world does not tell it."""

from __future__ import annotations

from collections.abc import Callable

from wakeful.facts.processes import ProcessView

#: Effort is counted in thousandths of a step, in whole numbers, so that sums don't depend on their order.
STEP = 1000

#: Totals above this count as this: a treatment that works longer is long enough.
_LONGEST = 256

Key = tuple[str, str, str]


class Effort:
    """What is known of one kind of process. What ``parent`` knows counts as much as half a process of its own.

    Args:
        parent: the experience of a wider kind; None for all processes together.
        assumed_steps: the total that is assumed where nothing is known at all.
    """

    def __init__(self, parent: Effort | None, assumed_steps: int) -> None:
        self._parent = parent
        self._assumed = assumed_steps
        self._totals: dict[int, int] = {}
        self._after_wait: dict[int, int] = {}
        self._waited = 0
        self._unwaited = 0
        self._longest_wait_ns: int | None = None

    def completed(self, steps: int, steps_before_wait: int | None, times: int = 1) -> None:
        """A process took ``steps`` in all, so many of them before it waited for the first time (None: it did not wait)."""
        steps = min(steps, _LONGEST)
        self._totals[steps] = self._totals.get(steps, 0) + times
        if steps_before_wait is None:
            self._unwaited += times
        else:
            left = steps - min(steps_before_wait, steps)
            self._after_wait[left] = self._after_wait.get(left, 0) + 1

    def waits(self) -> None:
        """A process waits for the first time."""
        self._waited += 1

    def woke(self, after_ns: int) -> None:
        """What a process waited for came so long after the process had begun."""
        self._longest_wait_ns = max(after_ns, self._longest_wait_ns or 0)

    @property
    def longest_wait_ns(self) -> int | None:
        """The longest that what was waited for took from a process's beginning; None where nothing was waited for yet."""
        if self._longest_wait_ns is None and self._parent is not None:
            return self._parent.longest_wait_ns
        return self._longest_wait_ns

    def left(self, steps_done: int) -> int:
        """The mean of what is left of a process that has done so many steps, in thousandths of a step; at least one step."""
        prior = self._parent.left(steps_done) if self._parent is not None else (self._assumed - steps_done) * STEP
        longer = [(total - steps_done, count) for total, count in self._totals.items() if total > steps_done]
        return _mean(longer, max(STEP, prior))

    def left_after_wait(self, steps_done: int) -> int:
        """The same for one whose first wait has just ended."""
        if self._after_wait:
            return _mean(list(self._after_wait.items()), STEP)
        return self._parent.left_after_wait(steps_done) if self._parent is not None else self.left(steps_done)

    def least_left(self, steps_done: int) -> int:
        """The least that such a process had left, in thousandths of a step."""
        longer = [total - steps_done for total in self._totals if total > steps_done]
        if longer:
            return min(longer) * STEP
        return self._parent.least_left(steps_done) if self._parent is not None else STEP

    def likely_waits(self) -> bool:
        """Whether at least as many of them wait as don't; where nothing is known, a process is taken to wait."""
        return self._share() >= 0.5

    def _share(self) -> float:
        prior = self._parent._share() if self._parent is not None else 0.5
        return (self._waited + prior) / (self._waited + self._unwaited + 1)


def _mean(values: list[tuple[int, int]], prior: int) -> int:
    halves = 1 + 2 * sum(times for _, times in values)
    return max(STEP, (prior + 2 * STEP * sum(value * times for value, times in values)) // halves)


class History:
    """Effort by (treatment, mode, kind of event). What is told at one instant counts from the next instant on, so that the
    order in which it is told makes no difference.

    Args:
        assumed_steps: the total that is assumed of a process before any was completed.
    """

    def __init__(self, assumed_steps: int) -> None:
        self._assumed = assumed_steps
        self._all = Effort(None, assumed_steps)
        self._kinds: dict[Key, Effort] = {}
        self._told: list[Callable[[], None]] = []
        self._ran_through: dict[tuple[Key, int], int] = {}
        self._ran_now: dict[tuple[Key, int], int] = {}
        self._ran_ns = 0
        self._told_ns = 0
        self._spent_ns = 0
        self._steps = 0

    @property
    def step_ns(self) -> int:
        """How long a step took in the mean; 0 before any process was completed."""
        return self._spent_ns // self._steps if self._steps else 0

    def of(self, view: ProcessView) -> Effort:
        """What is known of processes like this one."""
        return self._kinds.get(_key(view), self._all)

    def advance(self, now_ns: int) -> None:
        """Take up what was told before ``now_ns``."""
        if self._told and now_ns > self._told_ns:
            for learn in self._told:
                learn()
            self._told.clear()
        if self._ran_now and now_ns > self._ran_ns:
            self._take_up_now()
        if self._ran_through:
            for (key, steps), times in self._ran_through.items():
                self._all.completed(steps, None, times)
                self._of_kind(key).completed(steps, None, times)
                self._steps += steps * times
            self._ran_through.clear()

    def ran_through(self, key: Key, steps: int, now_ns: int) -> None:
        """A process like these was resolved within an instant, without a wait."""
        if now_ns > self._ran_ns:
            if self._ran_now:
                self._take_up_now()
            self._ran_ns = now_ns
        place = key, steps
        self._ran_now[place] = self._ran_now.get(place, 0) + 1

    def _take_up_now(self) -> None:
        ran = self._ran_through
        for place, times in self._ran_now.items():
            ran[place] = ran.get(place, 0) + times
        self._ran_now.clear()

    def completed(self, view: ProcessView, steps_before_wait: int | None, now_ns: int) -> None:
        """A process was resolved; ``view`` is its last one."""

        def learn() -> None:
            for effort in self._both(view):
                effort.completed(view.steps_done, steps_before_wait)
            self._spent_ns += view.spent_ns
            self._steps += view.steps_done

        self._tell(learn, now_ns)

    def waits(self, view: ProcessView, now_ns: int) -> None:
        """A process waits for the first time."""

        def learn() -> None:
            for effort in self._both(view):
                effort.waits()

        self._tell(learn, now_ns)

    def woke(self, view: ProcessView, now_ns: int) -> None:
        """The first wait of a process has ended."""
        after_ns = now_ns - (view.started_ns if view.started_ns is not None else view.arrived_ns)

        def learn() -> None:
            for effort in self._both(view):
                effort.woke(after_ns)

        self._tell(learn, now_ns)

    def _tell(self, learn: Callable[[], None], now_ns: int) -> None:
        self.advance(now_ns)
        self._told_ns = now_ns
        self._told.append(learn)

    def _both(self, view: ProcessView) -> tuple[Effort, Effort]:
        return self._all, self._of_kind(_key(view))

    def _of_kind(self, key: Key) -> Effort:
        found = self._kinds.get(key)
        if found is None:
            found = self._kinds[key] = Effort(self._all, self._assumed)
        return found


def _key(view: ProcessView) -> Key:
    return view.treatment, view.mode, view.kind
