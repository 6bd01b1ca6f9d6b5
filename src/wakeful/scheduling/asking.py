"""What processes ask and how it is answered: by memory, by evidence, from outside, by a child, or by the limit's passing."""

from __future__ import annotations

from collections.abc import Callable

import msgspec

from wakeful.facts.asking import Kind, Reply
from wakeful.facts.evidence import Evidence
from wakeful.facts.inputs import Answer, Call
from wakeful.facts.lines import Answered, Asked, Decided
from wakeful.facts.packs import Woken
from wakeful.facts.processes import State, Trigger
from wakeful.facts.time import to_ns
from wakeful.facts.values import NOTHING, Raw
from wakeful.scheduling.agenda import Agenda
from wakeful.scheduling.driving import EXPIRED
from wakeful.scheduling.evidence import EvidenceShelf
from wakeful.scheduling.host import Host
from wakeful.scheduling.process import Process
from wakeful.scheduling.process_set import ProcessSet
from wakeful.scheduling.thinking import WHICH_TREATMENT, revised
from wakeful.scheduling.wants import Want

#: The kinds that are answered from outside, by a call.
OUTSIDE = (Kind.DELIBERATE, Kind.ASK, Kind.CALL)


class Asking:
    """Records requests and their answers. It moves who waits and wakes, and leaves it to the scheduler to give slots anew.

    Args:
        host: the kernel.
        processes: who may ask.
        agenda: where limits are noted.
        shelf: evidence kept for who asks later.
    """

    def __init__(self, host: Host, processes: ProcessSet, agenda: Agenda, shelf: EvidenceShelf) -> None:
        self._host = host
        self._processes = processes
        self._agenda = agenda
        self._shelf = shelf

    # --- requests ---

    def ask(self, process: Process, want: Want, readable: Callable[[Want, Answered], bool]) -> Answered | None:
        """Record the request; answer it at once where that can be done, else (None) the process waits.

        What an earlier attempt was answered is the answer again, where today's code can read it (``readable``).
        """
        pending = process.pending
        fresh = pending is None
        if pending is None:
            pending = self.asked(process, want)
            self._host.write(pending)
            known = recorded_before(process, pending) if process.base_seq else None
            if known is not None and readable(want, known):
                process.want = want
                return self._at_once(pending, known.value, known.error)
        process.want = want
        if want.kind is Kind.RECALL and want.query is not None:
            return self._at_once(pending, encoded(self._host.recall(want.query)))
        if want.kind is Kind.EVIDENCE:
            came = self._arrived(process, pending)
            if len(came) >= pending.count:
                return self._at_once(pending, encoded(came[-pending.count :]))
        if fresh:
            self._host.write(process.moved(Trigger.ASK))
            self._agenda.limit(pending)
            self.call(process, want, pending)
        return None

    def asked(self, process: Process, want: Want) -> Asked:
        """The record of a request."""
        return Asked(
            process=process.id,
            seq=process.next_seq,
            kind=want.kind,
            key=want.key,
            expires_ns=None if want.within_s is None else self._host.now_ns + to_ns(max(0.0, want.within_s)),
            safety=want.safety,
            args=want.digest(),
            count=want.count,
            detail=encoded(want.event) if want.event is not None and want.event != process.event else NOTHING,
        )

    def _at_once(self, pending: Asked, value: Raw, error: str = "") -> Answered:
        place = {"process": pending.process, "seq": pending.seq}
        answered = Answered(**place, kind=pending.kind, key=pending.key, value=value, error=error)
        self._host.write(answered)
        return answered

    # --- calls outside ---

    def call(self, process: Process, want: Want, pending: Asked) -> None:
        """Have the call made that the request needs, if any; the reasoner's are made when their turn comes."""
        if want.kind in OUTSIDE and want.kind is not Kind.DELIBERATE:
            self._call(process, want, pending, process.asked_ns)

    def ask_the_reasoner(self) -> None:
        """Have the calls made whose turn has come; the others queue in the process set. After a recovery: all under way."""
        for each, since_ns in self._processes.reasoner_calls.take():
            process = self._processes[each]
            pending = process.pending
            if pending is None or not isinstance(process.want, Want):
                continue
            if pending.expires_ns is None or pending.expires_ns > self._host.now_ns:  # else its limit passes at this instant
                self._call(process, process.want, pending, since_ns)

    def _call(self, process: Process, want: Want, pending: Asked, since_ns: int) -> None:
        self._host.call(
            Call(
                process=process.id,
                seq=pending.seq,
                asked_ns=since_ns,
                expires_ns=pending.expires_ns if pending.expires_ns is not None else since_ns,
                question=want.question,
                role=want.role,
                function=want.function,
                safety=want.safety,
                key=f"{process.event.id}/{process.id}/{pending.seq}",
            )
        )

    # --- answers ---

    def take(self, answer: Answer) -> bool:
        """Record a call's answer. One that comes twice, or for a process that is gone, is passed over (False)."""
        process = self._processes.get(answer.process)
        pending = process.pending if process is not None else None
        if process is None or pending is None or pending.seq != answer.seq or pending.kind not in OUTSIDE:
            return False
        reply, error = _reply(process, pending, answer)
        self.answered(process, pending, NOTHING if error else answer.value, error, answer.cost_usd, answer.calls)
        if pending.key == WHICH_TREATMENT and reply is not None and process.decision is not None:
            decision = revised(process.decision, reply, self._host.counselled(process.decision, reply))
            self._host.write(Decided(process=process.id, event=process.event.id, decision=decision))
        return True

    def deliver(self, evidence: Evidence) -> list[Process]:
        """Keep the evidence, and wake whoever has now all that it asked for; nobody where it was there already."""
        woken: list[Process] = []
        if not self._shelf.put(evidence):
            return woken
        topic_key = f"{evidence.topic}\x1f{evidence.key}"
        for process in self._processes.expecting(topic_key):
            pending = process.pending
            if pending is not None:
                came = self._arrived(process, pending)
                if len(came) >= pending.count:
                    self.answered(process, pending, encoded(came[-pending.count :]), "")
                    woken.append(process)
        return woken

    def has_come(self, process: Process, asked: Asked) -> bool:
        """Whether all the evidence that a request is for is there already."""
        return self._shelf.holds(asked.key) and len(self._arrived(process, asked)) >= asked.count

    def _arrived(self, process: Process, pending: Asked) -> tuple[Evidence, ...]:
        taken = process.taken.get(pending.key, ())
        return tuple(each for each in self._shelf.of(pending.key, process.asked_ns) if each.id not in taken)

    def limit_passed(self, process: Process) -> bool:
        """Wake the process with what there is: the evidence that came, or the word that nothing did. False: it did not wait."""
        pending = process.pending
        if pending is None:
            return False
        if pending.kind is Kind.SLEEP:
            self.answered(process, pending, NOTHING, "")
        elif pending.kind is Kind.EVIDENCE:
            came = self._arrived(process, pending)
            self.answered(process, pending, encoded(came), "", trigger=Trigger.EXPIRE)
        else:
            calls = int(self._processes.reasoner_calls.is_under_way(process.id))  # it was made, and is paid for
            self.answered(process, pending, NOTHING, EXPIRED, calls=calls, trigger=Trigger.EXPIRE)
        return True

    def tell_parent(self, process: Process, value: Raw, error: str = "") -> None:
        """Answer the parent that waits for this child's result."""
        parent = self._processes.get(process.parent)
        pending = parent.pending if parent is not None else None
        treatment = process.decision.treatment if process.decision is not None else ""
        if parent is not None and pending is not None and pending.kind is Kind.TREAT and pending.key == treatment:
            self.answered(parent, pending, value, error)

    def answered(
        self,
        process: Process,
        pending: Asked,
        value: Raw,
        error: str,
        cost_usd: float = 0.0,
        calls: int = 0,
        trigger: Trigger = Trigger.WAKE,
    ) -> None:
        """Record the answer to ``pending``, and wake who waited for it."""
        answered = Answered(
            process=process.id,
            seq=pending.seq,
            kind=pending.kind,
            key=pending.key,
            value=value,
            error=error,
            cost_usd=cost_usd,
            calls=calls,
        )
        by = pending.key.replace("\x1f", " ")
        if pending.kind is Kind.EVIDENCE and process.state is State.WAITING:
            self._host.pack(Woken(answered=answered, trigger=trigger, steps=process.steps, by=by))
        else:
            self._host.write(answered)
            self._host.write(process.moved(trigger, by=by))


def _reply(process: Process, pending: Asked, answer: Answer) -> tuple[Reply | None, str]:
    """A reasoner's or a person's reply, and what is wrong with the answer, whoever made the call."""
    if answer.error or pending.kind not in (Kind.DELIBERATE, Kind.ASK):
        return None, answer.error
    try:
        reply = msgspec.json.decode(answer.value, type=Reply)
    except (msgspec.MsgspecError, UnicodeDecodeError) as error:
        return None, f"the answer is no reply: {error}"[:500]
    question = process.want.question if isinstance(process.want, Want) else None
    if question is not None and reply.choice not in question.options:
        return None, f"the answer {reply.choice[:80]!r} is none of the question's options"
    return reply, ""


def recorded_before(process: Process, pending: Asked) -> Answered | None:
    """What an earlier attempt of the process (before a restart, or in another mode) was answered to the same request.

    The n-th such request of this attempt has the n-th such answer: nothing outside that was answered is done again. What failed
    or came too late is asked anew, but for a call with effect, which is never made twice.
    """
    same = [each for each in process.asked if (each.kind, each.args) == (pending.kind, pending.args)]
    turn = sum(1 for each in same if each.seq > process.base_seq)
    before = [process.answers[each.seq] for each in same if each.seq <= process.base_seq and each.seq in process.answers]
    kept = [each for each in before if not each.error or pending.safety == "effect"]
    return kept[turn - 1] if turn <= len(kept) else None


def encoded(value: object) -> Raw:
    """A value as it is recorded."""
    return msgspec.Raw(msgspec.json.encode(value))
