"""systemd's notify protocol as the supervisor hears it: readiness, heartbeats while there is progress, none after a stall."""

from __future__ import annotations

import os
import socket
import threading
from collections.abc import Iterator
from pathlib import Path

import msgspec
import pytest

from wakeful import Event, MindView, Registry, Result, treatment
from wakeful.domains import load
from wakeful.drivers.assembly import assemble
from wakeful.drivers.sd_notify import Heart, Notifier
from wakeful.drivers.simulated import SimulatedDriver
from wakeful.facts.asking import Question, Reply
from wakeful.facts.domain import Guideline
from wakeful.facts.events import Draft
from wakeful.facts.settings import MindSettings
from wakeful.journal import MemoryJournal


class Called(Result, frozen=True, kw_only=True, tag="called"):
    """What the calling treatment concludes."""


class Supervisor:
    """The other end of the socket."""

    def __init__(self, address: str) -> None:
        self.socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self.socket.bind("\0" + address[1:] if address.startswith("@") else address)
        self.socket.settimeout(10.0)

    def next(self) -> list[str]:
        return self.socket.recv(4096).decode().splitlines()

    def silent_for(self, seconds: float) -> bool:
        self.socket.settimeout(seconds)
        try:
            self.next()
        except TimeoutError:
            return True
        finally:
            self.socket.settimeout(10.0)
        return False


@pytest.fixture(params=["path", "abstract"])
def place(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    return str(tmp_path / "notify") if request.param == "path" else f"@wakeful-test-{os.getpid()}-{tmp_path.name}"


@pytest.fixture
def supervisor(place: str) -> Iterator[Supervisor]:
    found = Supervisor(place)
    yield found
    found.socket.close()


def test_ready_and_stopping_are_told_with_a_status(place: str, supervisor: Supervisor) -> None:
    notifier = Notifier.from_environment({"NOTIFY_SOCKET": place}, os.getpid())
    assert notifier is not None
    heart = Heart(notifier)
    heart.ready(lambda: "3 admitted")
    assert supervisor.next() == ["READY=1", "STATUS=3 admitted"]
    heart.stop("the disk is full\nREADY=1")
    assert supervisor.next() == ["STOPPING=1", "STATUS=the disk is full READY=1"]


def test_beats_are_passed_on_while_there_is_progress_and_while_resting_and_not_after_a_stall(
    place: str, supervisor: Supervisor
) -> None:
    heart = Heart(Notifier(place, limit_s=0.06))
    heart.ready(str)
    assert supervisor.next()[0] == "READY=1"
    heart.beat()
    assert supervisor.next()[0] == "WATCHDOG=1"
    with heart:
        assert [supervisor.next()[0] for _ in range(3)] == ["WATCHDOG=1"] * 3
    supervisor.next()  # of the moment in which it rested no more
    while not supervisor.silent_for(0.2):
        pass
    heart.beat()
    assert supervisor.next()[0] == "WATCHDOG=1"
    heart.stop()


def test_to_wait_for_the_next_item_is_to_rest(place: str, supervisor: Supervisor) -> None:
    heart = Heart(Notifier(place, limit_s=0.06))
    heart.ready(str)
    supervisor.next()
    gate = threading.Event()

    def slow() -> Iterator[int]:
        yield 1
        gate.wait(10.0)
        yield 2

    items = iter(heart.over(slow()))
    assert next(items) == 1
    waiting = threading.Thread(target=lambda: next(items))
    waiting.start()
    assert [supervisor.next()[0] for _ in range(4)] == ["WATCHDOG=1"] * 4
    gate.set()
    waiting.join()
    assert list(items) == []
    heart.stop()


@pytest.mark.parametrize(
    ("environment", "limit_s"),
    [
        ({"WATCHDOG_USEC": "30000000"}, 30.0),
        ({"WATCHDOG_USEC": "30000000", "WATCHDOG_PID": "17"}, 30.0),
        ({"WATCHDOG_USEC": "30000000", "WATCHDOG_PID": "18"}, None),
        ({"WATCHDOG_USEC": "soon"}, None),
        ({"WATCHDOG_USEC": "0"}, None),
        ({}, None),
    ],
)
def test_the_limit_is_the_supervisors_and_only_for_this_process(environment: dict[str, str], limit_s: float | None) -> None:
    notifier = Notifier.from_environment({"NOTIFY_SOCKET": "/nowhere", **environment}, 17)
    assert notifier is not None
    assert notifier.limit_s == limit_s
    notifier.close()


@pytest.mark.parametrize("address", ["", "relative", "vsock:2:1234"])
def test_without_a_socket_that_we_speak_nobody_is_told(address: str) -> None:
    assert Notifier.from_environment({"NOTIFY_SOCKET": address}, 1) is None


def test_a_supervisor_that_is_gone_holds_nobody_up(tmp_path: Path) -> None:
    notifier = Notifier(str(tmp_path / "nobody"), limit_s=0.01)
    assert not notifier.tell("READY=1")
    heart = Heart(notifier)
    heart.ready(str)
    heart.beat()
    heart.stop()


def test_nobody_listening_costs_no_thread() -> None:
    heart = Heart()
    before = threading.active_count()
    heart.ready(str)
    heart.beat()
    assert threading.active_count() == before
    assert list(heart.over([1, 2])) == [1, 2]
    heart.stop()


def test_a_reasoner_that_is_waited_for_is_no_stall_and_a_call_that_never_ends_is_one(place: str, supervisor: Supervisor) -> None:
    rests: list[tuple[str, bool]] = []

    class Listening(Heart):
        """Tells whether it rests."""

        resting = False

        def __enter__(self) -> None:
            self.resting = True
            super().__enter__()

        def __exit__(self, *_: object) -> None:
            self.resting = False
            super().__exit__()

    heart = Listening(Notifier(place, limit_s=30.0))

    class Asked:
        """A reasoner that notes whether its waiting counts."""

        name = "asked"
        latency_s = 0.0

        async def answer(self, question: Question) -> Reply:
            rests.append(("reasoner", heart.resting))
            return Reply(choice=question.options[0], confidence=0.9, because=("asked",), reasoner=self.name)

    @treatment(name="caller", result=Called, says="Calls.")
    async def caller(event: Event, mind: MindView) -> Called:
        await mind.call(lambda: rests.append(("call", heart.resting)), "sensor", 5.0)
        return Called(says="called", confidence=1.0)

    spec = load("jsonl").spec
    rule = Guideline(treat="caller", because="it calls", when={"kind": "alarm"})
    only = msgspec.structs.replace(spec, treatments=("caller",), guideline=(rule,))

    class Domain:
        """The plain domain with that treatment."""

        spec = only

        def detectors(self) -> dict[str, object]:
            return {}

        def simulate(self, seed: int) -> None:
            return None

    kernel, learner = assemble(Domain(), MindSettings(), registry=Registry(own=(caller,), installed=()))  # type: ignore[arg-type]
    driver = SimulatedDriver(kernel, MemoryJournal(), Asked(), learner, heart=heart)
    alarm = Draft(kind="alarm", entity="pump", source="s", position=0, at_ns=10**18)
    for _ in driver.run("s", "d", lambda after: [alarm][after + 1 :]):
        pass
    driver.close()
    assert rests == [("reasoner", True), ("call", False)]
    assert supervisor.next()[0] == "READY=1"
