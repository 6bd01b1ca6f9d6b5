"""The straight way: a process without a rival runs from its dispatch to its end, or to its first wait, and writes that as one.

What it does is what the scheduler does step by step; where anything is out of the ordinary it hands over to that.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import msgspec

from wakeful.facts.asking import Kind
from wakeful.facts.crashes import mark
from wakeful.facts.evidence import Evidence
from wakeful.facts.lines import Asked
from wakeful.facts.packs import Inquired, Ran
from wakeful.facts.processes import Trigger
from wakeful.facts.results import Result
from wakeful.facts.time import LONGEST_S
from wakeful.scheduling.agenda import Agenda
from wakeful.scheduling.asking import Asking
from wakeful.scheduling.driving import Coroutines, Step, ended, failed, objection, wanted
from wakeful.scheduling.host import Host
from wakeful.scheduling.process import Process
from wakeful.scheduling.process_set import ProcessSet
from wakeful.scheduling.running import Running
from wakeful.scheduling.wants import Want, Work

_encode = msgspec.json.Encoder().encode
_EVIDENCE = msgspec.json.Decoder(tuple[Evidence, ...])


class Straight:
    """Runs automatic processes where steps take no kernel time.

    Args:
        host: the kernel.
        processes: says whether a process has rivals.
        coroutines: whose treatments and page are used.
        asking: makes the record of a request.
        running: takes over what is out of the ordinary.
        agenda: where limits are noted, and steps that are left.
    """

    def __init__(
        self, host: Host, processes: ProcessSet, coroutines: Coroutines, asking: Asking, running: Running, agenda: Agenda
    ) -> None:
        self._host = host
        self._processes = processes
        self._coroutines = coroutines
        self._asking = asking
        self._running = running
        self._agenda = agenda
        self._instant = host.settings.step_s == 0.0
        self._max_steps = host.settings.max_steps
        self._window_ns = host.closes_ns(0)

    def run(self, process: Process) -> bool:
        """Run it. False where the slots have to be settled: it has to compete, is not an automatic root process, or has come to
        something out of the ordinary."""
        choice = process.choice
        if not self._instant or choice is None or process.parent or not self._processes.unrivalled(process):
            return False
        left = self._host.steps_left
        if left == 0 or self._processes.crashes.of(process.event.id):
            return False
        steps = process.steps - process.base_steps
        limit = self._max_steps if left is None else min(self._max_steps, steps + left)
        began = steps
        resume, value = self._begin(process)
        if resume is None:
            return False
        page = self._coroutines.page
        mark(page, process.event.id)
        want: object = None
        end: Callable[[], Step] | None = None
        try:
            want = resume(value)
            while want.__class__ is Work and steps + want.left <= limit:
                steps += want.left
                want = resume(None)
        except StopIteration as stop:
            end = ended(stop.value)
            want = stop.value
        except KeyboardInterrupt:
            raise
        except BaseException as error:  # a user's code may raise anything, SystemExit too; the event keeps its process
            end = failed(error)
        finally:
            page[0] = 0
        self._host.spent(steps - began)
        total = process.base_steps + steps
        if end is None:
            if isinstance(want, Want) and self._waits(process, want, total):
                return True
            end = wanted(want)
        elif isinstance(want, Result) and not objection(want):
            self._conclude(process, choice.basis.treatment, want, total)
            return True
        # It holds the slot now, so many steps on: what it has come to is seen to by the ordinary way.
        before = process.steps
        self._host.write(process.moved(Trigger.DISPATCH))
        process.ran = total - before
        self._running.go_on(process, end)
        return False

    def _begin(self, process: Process) -> tuple[Callable[[Any], object] | None, object]:
        """How its coroutine goes on, and with what; (None, None) where it has to be rebuilt first."""
        if process.coroutine is not None:
            want = process.want
            if not isinstance(want, Want) or want.kind is not Kind.EVIDENCE:
                return None, None
            answered = process.answers[process.asked[-1].seq]
            if process.mind is not None:
                process.mind.heard_ns = process.answered_ns[answered.seq]
            return process.coroutine.send, _EVIDENCE.decode(answered.value) if not answered.error else ()
        if process.asked or process.steps or process.choice is None:
            return None, None
        if not self._coroutines.begin(process, process.choice) or process.coroutine is None:
            return None, None
        return process.coroutine.send, None

    def _conclude(self, process: Process, treatment: str, result: Result, steps: int) -> None:
        forecast = result.forecast
        burst = Ran(
            process=process.id,
            event=process.event.id,
            before=process.state,
            steps_before=process.steps,
            steps=steps,
            treatment=treatment,
            mode="auto",
            result=msgspec.Raw(_encode(result)),
            closes_ns=None if forecast is None else process.arrived_ns + self._window_ns,
        )
        self._host.resolved(burst, forecast)

    def _waits(self, process: Process, want: Want, steps: int) -> bool:
        """Record that it waits for evidence that has not come; False where it is for the scheduler to see to what it wants."""
        if want.kind is not Kind.EVIDENCE or process.base_seq or (want.within_s is not None and not want.within_s <= LONGEST_S):
            return False
        if process.next_seq > self._host.settings.max_requests:
            return False
        asked: Asked = self._asking.asked(process, want)
        if self._asking.has_come(process, asked):
            return False
        process.want = want
        self._host.pack(Inquired(before=process.state, steps_before=process.steps, asked=asked, steps=steps))
        self._agenda.limit(asked)
        return True
