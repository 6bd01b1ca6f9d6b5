"""Long waiters are parked outside memory and taken up again: nothing that is recorded shows it."""

from __future__ import annotations

import logging
from collections.abc import Callable

import msgspec
import pytest

from wakeful import Event, MindView, Registry, Result, treatment
from wakeful.contracts.aside import AsideFull
from wakeful.domains import load
from wakeful.drivers.assembly import assemble
from wakeful.facts.asking import Reply
from wakeful.facts.domain import DomainSpec, Guideline
from wakeful.facts.events import Draft
from wakeful.facts.evidence import Evidence
from wakeful.facts.inputs import Act, Answer, Begin, Input, Mark
from wakeful.facts.lines import Admitted, Concluded, Line
from wakeful.facts.settings import MindSettings
from wakeful.facts.time import to_ns
from wakeful.journal import MemoryJournal
from wakeful.journal.aside import AsideFile
from wakeful.journal.audit import audit
from wakeful.journal.export import exported
from wakeful.scheduling import agenda

LIMIT_S = 60.0


class Heard(Result, frozen=True, kw_only=True, tag="heard"):
    """What the treatment concludes: what it was told, first and then."""

    told: tuple[str, str]


@treatment(name="listen", result=Heard, says="Waits for one reading, and then for another.")
async def listen(event: Event, mind: MindView) -> Heard:
    """Waits twice, with a step before, between and after."""
    told = []
    for topic in ("first", "second"):
        await mind.work()
        came = await mind.evidence(topic, event.entity, LIMIT_S)
        told.append(str(msgspec.json.decode(came[0].value)) if came else "nothing")
    await mind.work()
    return Heard(says=" and ".join(told), confidence=1.0, told=(told[0], told[1]))


class Listening:
    """The plain domain with that one treatment."""

    def __init__(self) -> None:
        plain = load("jsonl")
        rule = Guideline(treat="listen", because="every event is listened to", when={"kind": "alarm"})
        self.spec: DomainSpec = msgspec.structs.replace(plain.spec, treatments=("listen",), guideline=(rule,))
        self.detectors = plain.detectors
        self.simulate = plain.simulate


class Mind:
    """A kernel with its journal. Whatever is asked of the reasoner is answered at once."""

    def __init__(self, keep_waiting: int) -> None:
        self.journal = MemoryJournal()
        self.keep_waiting = keep_waiting
        self.position = -1
        self._make()
        self.feed(Begin(source="alarms", digest="alarms"))

    def _make(self) -> None:
        settings = MindSettings(step_s=0.0, keep_waiting=self.keep_waiting)
        self.kernel, _ = assemble(Listening(), settings, registry=Registry(own=(listen,), installed=()))

    def feed(self, *inputs: Input, after_s: float = 0.001) -> None:
        requests = self.kernel.feed(inputs, self.kernel.now_ns + to_ns(after_s))
        self.journal.commit(requests.lines, self.kernel.changed(), requests.blobs)
        reply = msgspec.Raw(msgspec.json.encode(Reply(choice="listen", confidence=0.9, because=("told to",))))
        for call in requests.calls:
            self.feed(Answer(process=call.process, seq=call.seq, value=reply))

    def meet(self, count: int) -> None:
        for _ in range(count):
            self.position += 1
            draft = Draft(
                kind="alarm",
                entity=f"pump {self.position}",
                source="alarms",
                position=self.position,
                at_ns=self.kernel.now_ns,
                fields={"pressure": 3.25, "open": True, "note": "naïve \x00 text"},
            )
            self.feed(draft, Mark(source="alarms", position=self.position))

    def tell(self, topic: str, number: int) -> None:
        value = msgspec.Raw(msgspec.json.encode(f"{topic} {number}"))
        self.feed(
            Evidence(id=f"{topic}{number}", topic=topic, key=f"pump {number}", at_ns=self.kernel.now_ns, value=value),
        )

    def crash(self) -> None:
        self._make()
        requests = self.kernel.recover(self.journal.entries(), self.journal.state(), {})
        self.journal.commit(requests.lines, self.kernel.changed(), requests.blobs)

    @property
    def parked(self) -> int:
        return len(self.kernel._scheduler.processes.parked)

    @property
    def open(self) -> int:
        return len(self.kernel._scheduler.processes)

    def said(self) -> dict[str, str]:
        """What was concluded, by entity."""
        events, found = {}, {}
        for line in self.journal.lines():
            if isinstance(line.record, Admitted):
                events[line.record.event.id] = line.record.event.entity
            elif isinstance(line.record, Concluded):
                found[events[line.record.event]] = msgspec.json.decode(line.record.result)["says"]
        return found


def both(script: Callable[[Mind], None], keep_waiting: int = 2) -> tuple[Mind, Mind]:
    """The same with everybody at hand, and with all but a few parked."""
    minds = Mind(4_096), Mind(keep_waiting)
    for mind in minds:
        script(mind)
    return minds


def stable(mind: Mind) -> list[Line]:
    return list(exported(mind.journal, stable=True))


def test_the_oldest_waiters_are_parked_and_still_count_as_open() -> None:
    mind = Mind(2)
    mind.meet(7)
    assert mind.parked == 5
    assert mind.open == 7
    assert [each.event.entity for each in mind.kernel._scheduler.processes] == ["pump 5", "pump 6"]


def test_evidence_wakes_who_is_parked_and_it_goes_on_where_it_was() -> None:
    def script(mind: Mind) -> None:
        mind.meet(6)
        for number in (0, 5, 3):
            mind.tell("first", number)
        mind.meet(3)  # who waits for the second reading is parked again
        for number in (3, 0, 5):
            mind.tell("second", number)

    calm, parking = both(script)
    assert parking.said() == {f"pump {n}": f"first {n} and second {n}" for n in (0, 3, 5)}
    assert stable(parking) == stable(calm)
    assert audit(parking.journal).ok


def test_the_limit_of_who_is_parked_passes_when_it_is_due() -> None:
    def script(mind: Mind) -> None:
        mind.meet(6)
        mind.feed(after_s=LIMIT_S - 0.004)
        mind.feed(after_s=2.0)
        mind.tell("second", 1)
        mind.feed(after_s=LIMIT_S)

    calm, parking = both(script)
    assert parking.parked == 0
    assert parking.said()["pump 1"] == "nothing and second 1"
    assert parking.said()["pump 4"] == "nothing and nothing"
    assert stable(parking) == stable(calm)


def test_the_next_limit_of_who_is_parked_wakes_the_driver() -> None:
    mind = Mind(0)
    mind.meet(1)
    assert mind.parked == 1
    requests = mind.kernel.feed((), mind.kernel.now_ns)
    assert requests.wake_ns is not None
    assert requests.wake_ns <= mind.kernel.now_ns + to_ns(LIMIT_S)


def test_an_operator_reaches_who_is_parked() -> None:
    def script(mind: Mind) -> None:
        mind.meet(5)
        mind.feed(Act(act="hold", process=1, who="Ada", why="to look at it"))
        mind.tell("first", 0)
        mind.feed(Act(act="release", process=1, who="Ada", why="seen"))
        mind.feed(Act(act="cancel", process=2, who="Ada", why="not wanted"))
        mind.tell("first", 1)

    calm, parking = both(script, keep_waiting=0)
    assert stable(parking) == stable(calm)
    assert audit(parking.journal).ok


def test_a_crash_forgets_who_is_parked_and_recovery_brings_all_back() -> None:
    def script(mind: Mind) -> None:
        mind.meet(6)
        mind.tell("first", 2)
        if mind.keep_waiting < 10:
            mind.crash()
        mind.feed()
        mind.tell("first", 4)
        mind.tell("second", 2)
        mind.tell("second", 4)

    calm, parking = both(script)
    assert parking.parked > 0
    assert stable(parking) == stable(calm)


def test_where_nothing_can_be_put_away_everybody_stays_at_hand(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def full(self: AsideFile, process: int, text: bytes) -> None:
        raise AsideFull("waiting processes cannot be parked: no room")

    mind = Mind(2)
    monkeypatch.setattr(AsideFile, "put", full)
    with caplog.at_level(logging.WARNING):
        mind.meet(6)
    assert mind.parked == 0
    assert "no room" in caplog.text
    mind.tell("first", 0)
    mind.tell("second", 0)
    assert mind.said() == {"pump 0": "first 0 and second 0"}


def test_limits_of_waits_that_are_over_do_not_pile_up(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(agenda, "_FEW", 8)
    mind = Mind(4_096)
    for number in range(40):
        mind.meet(1)
        mind.tell("first", number)
        mind.tell("second", number)
    assert mind.open == 0
    assert len(mind.kernel._scheduler._agenda._limits) <= 2 + 8


def test_an_event_may_be_thought_about_again_while_a_process_of_it_is_parked() -> None:
    def script(mind: Mind) -> None:
        mind.meet(1)
        mind.feed(after_s=LIMIT_S + 1.0)
        mind.feed(after_s=LIMIT_S + 1.0)
        event = next(line.record.event.id for line in mind.journal.lines() if isinstance(line.record, Admitted))
        for turn in ("first", "second", "third"):
            mind.feed(Act(act="reopen", process=1, event=event, who="Ada", why=f"a {turn} look"))
        mind.tell("first", 0)
        mind.tell("second", 0)
        mind.feed(after_s=LIMIT_S + 1.0)

    calm, parking = both(script, keep_waiting=0)
    assert len([line for line in parking.journal.lines() if isinstance(line.record, Concluded)]) == 4
    assert stable(parking) == stable(calm)
    assert audit(parking.journal).ok
