"""Runs a process's coroutine on until it works, waits or ends. Whatever the treatment does, the event keeps its process."""

from __future__ import annotations

from collections.abc import Callable

from wakeful.facts.asking import Kind
from wakeful.facts.crashes import QUARANTINED
from wakeful.facts.lines import RESUMPTION, Asked, Concluded, Decided
from wakeful.facts.named import MISMATCH, REMOVED
from wakeful.facts.processes import State, Trigger
from wakeful.facts.results import Result, Unresolved
from wakeful.facts.time import LONGEST_S
from wakeful.facts.values import NOTHING
from wakeful.scheduling.asking import OUTSIDE, Asking, encoded
from wakeful.scheduling.driving import Coroutines, Failure, Mismatch, Step, objection
from wakeful.scheduling.host import Host
from wakeful.scheduling.process import Process
from wakeful.scheduling.process_set import ProcessSet
from wakeful.scheduling.thinking import provisional
from wakeful.scheduling.wants import Want, Work

#: What an Answered says in ``error`` when a call with effect was in doubt after a crash: a person is told, it is never retried.
IN_DOUBT = "in doubt after a crash: a call with effect is never made again"


class Running:
    """Drives coroutines between two points at which the scheduler may take their slot.

    Args:
        host: the kernel.
        processes: the process set, for who stands above whom.
        coroutines: starts, answers and rebuilds them.
        asking: takes up what they ask.
        begin_child: gives an event a process of its own below the one that asked for it.
    """

    def __init__(
        self,
        host: Host,
        processes: ProcessSet,
        coroutines: Coroutines,
        asking: Asking,
        begin_child: Callable[[Process, Want], None],
    ) -> None:
        self._host = host
        self._processes = processes
        self._coroutines = coroutines
        self._asking = asking
        self._begin_child = begin_child

    def dispatched(self, process: Process) -> None:
        """It holds a slot: start or rebuild its coroutine, or give it the answer that it waited for."""
        if process.coroutine is None:
            self.rebuild(process)
        elif isinstance(process.want, Want):
            answered = process.answers[process.asked[-1].seq]
            self.go_on(process, lambda: self._coroutines.answer(process, _want(process), answered))

    def rebuild(self, process: Process) -> None:
        """Run it again over its recorded answers and steps, and on from there; or never again, where that ends every run."""
        if self._poisonous(process):
            self._quarantine(process)
            return
        self.go_on(process, lambda: self._coroutines.rebuild(process, process.steps + process.ran))

    def step_ended(self, process: Process) -> None:
        """One step of its work is done; it goes on where that was the last."""
        process.stepping = False
        process.ran += 1
        self._processes.stepped(process, self._host.now_ns)
        if isinstance(process.want, Work):
            process.want.left -= 1
            if process.want.left <= 0:
                self.go_on(process, lambda: self._coroutines.send(process, None))

    def go_on(self, process: Process, run: Callable[[], Step]) -> None:
        """Run the coroutine on until it works, waits or ends. ``run`` gives its next want."""
        step = self._attempt(process, run)
        while step is not None:
            excess = self._excess(process, step)
            if excess:
                self._fail(process, excess)
                return
            if isinstance(step, Work):
                process.want = step
                return
            if isinstance(step, Result):
                self._conclude(process, step)
                return
            step = self._ask(process, step)

    def _ask(self, process: Process, want: Want) -> Step | None:
        fresh = process.pending is None
        answered = self._asking.ask(process, want, self._coroutines.readable)
        if answered is not None:
            return self._attempt(process, lambda: self._coroutines.answer(process, want, answered))
        if fresh and want.kind is Kind.TREAT:
            self._begin_child(process, want)
        return None

    # --- limits and failures ---

    def _excess(self, process: Process, step: Step) -> str:
        """What is wrong with a want or a result, so that the attempt has failed; empty where nothing is."""
        own = self._host.settings
        if isinstance(step, Result):
            return objection(step)
        if isinstance(step, Work):
            spent = process.steps + process.ran - process.base_steps + step.left
            return f"it wanted {spent} steps of work in all; at most {own.max_steps} are given" if spent > own.max_steps else ""
        if step.within_s is not None and not step.within_s <= LONGEST_S:
            return f"it wanted to wait {step.within_s} s for {step.kind}; every wait needs a limit of at most {LONGEST_S:g} s"
        if process.pending is None and process.next_seq - process.base_seq > own.max_requests:
            return f"it made more than {own.max_requests} requests"
        if step.kind is Kind.TREAT and self._depth(process) >= own.max_depth:
            return f"its children were nested deeper than {own.max_depth}"
        return ""

    def _depth(self, process: Process) -> int:
        depth = 0
        above = self._processes.get(process.parent)
        while above is not None:
            depth += 1
            above = self._processes.get(above.parent)
        return depth

    def _attempt(self, process: Process, run: Callable[[], Step]) -> Step | None:
        try:
            return run()
        except Mismatch as mismatch:
            self._restart(process, mismatch)
        except Failure as failure:
            self._fail(process, str(failure))
        return None

    def _restart(self, process: Process, mismatch: Mismatch) -> None:
        """Begin again from the event: named, never stranded."""
        detail = f"{mismatch}; restarted from its event"
        self._host.note(MISMATCH, detail, process.id, process.event.id)
        self._host.write(process.moved(Trigger.RESTART))

    def removed(self, process: Process) -> bool:
        """Its treatment is not registered any more: it is named and begins again in fallback mode, by a general treatment.

        A child fails instead, and whoever waits for it hears so. Whether that was so.
        """
        decision = process.decision
        if decision is None or self._coroutines.knows(decision.treatment):
            return False
        instead = self._coroutines.instead_of(decision.treatment)
        why = f"{decision.treatment} is not registered any more"
        going_on = f"; goes on in fallback mode, by {instead}" if instead and not process.parent else ""
        self._host.note(REMOVED, why + going_on, process.id, process.event.id)
        if process.state is not State.CREATED:
            self._host.write(process.moved(Trigger.RESTART))
        if instead and not process.parent:
            self._host.write(Decided(process=process.id, event=process.event.id, decision=provisional(decision, why, instead)))
        return True

    def _fail(self, process: Process, why: str) -> None:
        """Continue in fallback mode; what fails there too is completed as unresolved, and is debt."""
        decision = process.decision
        gone = decision is not None and not self._coroutines.knows(decision.treatment)
        if gone and not process.parent and self._coroutines.instead_of(decision.treatment if decision is not None else ""):
            self.removed(process)
            return
        if decision is not None and decision.mode != "fallback" and not gone:
            self._host.note("treatment failed", f"{decision.treatment}: {why}", process.id, process.event.id)
            self._host.write(process.moved(Trigger.RESTART))
            self._host.write(Decided(process=process.id, event=process.event.id, decision=provisional(decision, why)))
            return
        self._host.note("treatment failed in fallback mode", why, process.id, process.event.id)
        unresolved = Unresolved(says=f"No treatment could be completed: {why}", confidence=0.0, failure=why)
        self._conclude(process, unresolved, Trigger.FAIL)

    def _poisonous(self, process: Process) -> bool:
        return self._processes.crashes.of(process.event.id) >= self._host.settings.tries

    def _quarantine(self, process: Process) -> None:
        """Its code is not run again: it is completed as unresolved, and its event is debt, while the others go on."""
        tries = self._processes.crashes.of(process.event.id)
        why = f"the mind's process ended {tries} times while this event was being treated"
        self._host.note(QUARANTINED, why, process.id, process.event.id)
        self._conclude(process, Unresolved(says=f"Quarantined: {why}.", confidence=0.0, failure=why), Trigger.FAIL)

    # --- ends ---

    def _conclude(self, process: Process, result: Result, trigger: Trigger = Trigger.RESOLVE) -> None:
        decision = process.decision
        root = process.parent == 0
        forecast = result.forecast if root else None
        record = Concluded(
            process=process.id,
            event=process.event.id,
            treatment=decision.treatment if decision is not None else "",
            mode=decision.mode if decision is not None else "",
            result=encoded(result),
            forecast=forecast,
            closes_ns=self._host.closes_ns(process.arrived_ns) if forecast is not None else None,
        )
        self._host.write(record)
        self._host.write(process.moved(trigger))
        if process.parent:
            self._asking.tell_parent(process, record.result)
        self._host.concluded(process.id)

    # --- recovery ---

    def warm(self, process: Process) -> None:
        """Rebuild the coroutine of a process that waits; where that fails it stays cold, and is rebuilt when it goes on."""
        try:
            want = self._coroutines.rebuild(process, process.steps)
        except (Mismatch, Failure):
            process.coroutine = process.mind = process.want = None
        else:
            process.want = want if isinstance(want, Want) else None

    def wait_again(self, process: Process, pending: Asked) -> None:
        """Take a recorded wait up again. What goes outside follows its class: one with effect is in doubt, others go again."""
        if pending.kind not in OUTSIDE:
            return
        if self._processes.reasoner_calls.is_under_way(process.id):
            self._host.note(RESUMPTION, f"request {pending.seq} to the reasoner was under way: made again", process.id)
        if pending.safety == "effect":
            self._asking.answered(process, pending, NOTHING, IN_DOUBT)
            return
        if self._poisonous(process):
            self._asking.answered(process, pending, NOTHING, QUARANTINED)
            return
        try:
            want = self._coroutines.rebuild(process, process.steps)
        except Mismatch as mismatch:
            self._restart(process, mismatch)
            return
        except Failure as failure:
            self._host.note("treatment failed", str(failure), process.id, process.event.id)
            self._host.write(process.moved(Trigger.RESTART))
            return
        if isinstance(want, Want):
            process.want = want
            self._asking.call(process, want, pending)


def _want(process: Process) -> Want:
    if not isinstance(process.want, Want):
        raise Mismatch("the process was not asking for anything")
    return process.want
