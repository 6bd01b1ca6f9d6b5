"""A mind that answers from a script, and a trampoline that drives a treatment with it: no kernel, no clock, no journal."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Coroutine, Generator, Mapping, Sequence
from inspect import isawaitable
from math import isfinite
from types import coroutine
from typing import TypeVar, cast

import msgspec

from wakeful.contracts.treatment import Refusal, Treatment
from wakeful.facts.asking import Episode, Query, Question, Reply, Safety
from wakeful.facts.decisions import Decision, Gate, Mode
from wakeful.facts.domain import DomainSpec
from wakeful.facts.events import Event
from wakeful.facts.evidence import Evidence
from wakeful.facts.results import Forecast, Result
from wakeful.facts.time import to_s
from wakeful.testing.broken import ContractBroken, require

T = TypeVar("T")


class Script(msgspec.Struct, frozen=True, kw_only=True):
    """What a scripted mind knows and answers. Empty: nothing is remembered, nobody answers, every wait expires.

    ``evidence`` arrives at its ``at_ns`` by kernel time. ``replies`` are a reasoner's by the question's ``about``, ``people`` a
    person's by role, ``children`` treatments by name. ``now_s`` is when the treatment starts, ``step_s`` what a step takes;
    ``consults``: treatments may put questions of their own.
    """

    prior: dict[str, float] = {}
    advice: Reply | None = None
    episodes: tuple[Episode, ...] = ()
    evidence: tuple[Evidence, ...] = ()
    replies: Mapping[str, Reply] = {}
    people: Mapping[str, Reply] = {}
    children: Mapping[str, Treatment] = {}
    now_s: float = 0.0
    step_s: float = 0.0
    consults: bool = False


class Request(msgspec.Struct, frozen=True, kw_only=True):
    """One thing that a treatment awaited: its kind and key, and its arguments as JSON."""

    kind: str
    key: str = ""
    args: bytes = b""
    within_s: float | None = None


class Exchange(msgspec.Struct, frozen=True, kw_only=True):
    """A request with its answer, or why it was refused, and the time after it."""

    request: Request
    answer: object = None
    refused: str = ""
    now_s: float = 0.0


class Asking(msgspec.Struct, frozen=True):
    """What a mind's coroutine yields to the trampoline: the request, and how the script answers it."""

    request: Request
    answer: Callable[[], object]


@coroutine
def _give(asking: Asking) -> Generator[Asking, object, object]:
    return (yield asking)


class Evicted(Exception):
    """The coroutine was closed before its result, on purpose."""


class ScriptedMind:
    """A Mind over a Script. It records every exchange; given ``recorded`` ones it answers from them first and refuses to go on
    where the treatment asks for something else, as the kernel does after a crash.

    Args:
        domain: the domain's data.
        mode: how the treatment is executed.
        script: what is known and answered.
        recorded: exchanges of an earlier run.
    """

    def __init__(self, domain: DomainSpec, mode: Mode = "auto", script: Script | None = None, recorded: Sequence[Exchange] = ()):
        self._domain = domain
        self._mode: Mode = mode
        self.script = Script() if script is None else script
        self._recorded = tuple(recorded)
        self._now_s = self.script.now_s
        self._delivered: set[str] = set()
        self.exchanges: list[Exchange] = []

    @property
    def mode(self) -> Mode:
        """How this process is executed."""
        return self._mode

    @property
    def decision(self) -> Decision:
        """A decision that says nothing but the mode and the prior."""
        gate = Gate(confidence=0.0, threshold=0.0, novelty=0.0, novelty_limit=0.0, trust=0.0, trust_limit=0.0)
        prior = dict(self.script.prior)
        return Decision(treatment="", mode=self._mode, confidence=0.0, candidates=(), reasons=(), gate=gate, prior=prior)

    @property
    def domain(self) -> DomainSpec:
        """The domain's data."""
        return self._domain

    @property
    def prior(self) -> dict[str, float]:
        """The script's prior, a fresh copy each time."""
        return dict(self.script.prior)

    @property
    def advice(self) -> Reply | None:
        """The script's advice, in delib mode."""
        return self.script.advice if self._mode == "delib" else None

    @property
    def consults(self) -> bool:
        """As the script says, in delib mode."""
        return self.script.consults and self._mode == "delib"

    @property
    def now_s(self) -> float:
        """Scripted time after the last exchange."""
        return self._now_s

    def forecast(self) -> Forecast | None:
        """The prior's most probable label."""
        prior = self.script.prior
        if not prior:
            return None
        label = max(sorted(prior), key=lambda each: prior[each])
        return Forecast(label=label, probability=prior[label], probabilities=dict(prior), topic=self._domain.outcome.topic)

    async def work(self, steps: int = 1) -> None:
        """Spend ``steps`` × ``step_s``."""
        require(isinstance(steps, int) and steps >= 0, f"work({steps!r}): steps are a whole number, 0 or more")
        await _give(Asking(Request(kind="work", key=str(steps)), lambda: self._pass(steps * self.script.step_s)))

    async def evidence(self, topic: str, key: str, within_s: float, count: int = 1) -> tuple[Evidence, ...]:
        """The script's evidence of that address which arrives in time, each piece once."""
        request = Request(kind="evidence", key=f"{topic}\x1f{key}", args=_json(count), within_s=_limit(within_s))
        found = await _give(Asking(request, lambda: self._arriving(topic, key, within_s, count)))
        return cast("tuple[Evidence, ...]", found)

    async def recall(self, query: Query) -> tuple[Episode, ...]:
        """The script's episodes that the query means: the likest first, equally like ones newest first."""
        return cast("tuple[Episode, ...]", await _give(Asking(_recall(query), lambda: self._recalled(query))))

    async def deliberate(self, question: Question) -> Reply:
        """The script's reply to what the question is about. Raises Refusal where there is none, and outside delib mode."""
        request = Request(kind="deliberate", key=question.about, args=_json(question))
        return cast("Reply", await _give(Asking(request, lambda: self._replied(question))))

    async def ask(self, role: str, question: Question, within_s: float) -> Reply | None:
        """The script's person; None after the limit where there is none."""
        request = Request(kind="ask", key=f"{role}\x1f{question.about}", args=_json(question), within_s=_limit(within_s))
        return cast("Reply | None", await _give(Asking(request, lambda: self._person(role, within_s))))

    async def treat(self, name: str, event: Event) -> Result:
        """The script's treatment of that name, driven by a mind of its own over the same script."""
        return cast(
            "Result", await _give(Asking(Request(kind="treat", key=name, args=_json(event)), lambda: self._child(name, event)))
        )

    async def call(self, function: Callable[[], T | Awaitable[T]], key: str, within_s: float, safety: Safety = "read") -> T:
        """The function, run here and now; its answer goes through JSON. Raises Refusal where it fails."""
        request = Request(kind="call", key=key, args=_json(safety), within_s=_limit(within_s))
        return cast("T", await _give(Asking(request, lambda: _called(function))))

    async def sleep_s(self, seconds: float) -> None:
        """Let scripted time pass."""
        request = Request(kind="sleep", within_s=_limit(seconds))
        await _give(Asking(request, lambda: self._pass(max(seconds, 0.0))))

    def run(self, treatment: Treatment, event: Event, stop_after: int | None = None) -> Result:
        """Drive a treatment to its result, as the kernel would.

        Args:
            treatment: what is driven.
            event: what it thinks about.
            stop_after: close the coroutine after so many answers, as an eviction does.

        Raises:
            ContractBroken: it awaited what is not the mind's, asked otherwise than recorded, or did not let itself be closed.
            Evicted: ``stop_after`` was reached.
            Exception: whatever the treatment raises.
        """
        thinking: Coroutine[object, object, Result] = treatment.treat(event, self)
        exchange: Exchange | None = None
        try:
            while True:
                if exchange is not None and exchange.refused:
                    asking = thinking.throw(Refusal(exchange.refused))
                else:
                    asking = thinking.send(None if exchange is None else exchange.answer)
                if not isinstance(asking, Asking):
                    raise ContractBroken(f"{treatment.name} awaited {asking!r}: a treatment awaits only what its mind gives")
                if stop_after is not None and len(self.exchanges) >= stop_after:
                    raise Evicted
                exchange = self._settle(asking)
        except StopIteration as done:
            return cast("Result", done.value)
        finally:
            _close(treatment, thinking)

    def _settle(self, asking: Asking) -> Exchange:
        at = len(self.exchanges)
        if at < len(self._recorded):
            exchange = self._recorded[at]
            require(
                exchange.request == asking.request,
                f"request {at + 1} was {_named(exchange.request)}; over the same answers the treatment now asks for "
                f"{_named(asking.request)}: between awaits it must depend on its event and answers alone",
            )
            self._now_s = exchange.now_s
        else:
            try:
                exchange = Exchange(request=asking.request, answer=asking.answer(), now_s=self._now_s)
            except Refusal as refusal:
                exchange = Exchange(request=asking.request, refused=str(refusal) or "refused", now_s=self._now_s)
        self.exchanges.append(exchange)
        return exchange

    def _pass(self, seconds: float) -> None:
        self._now_s += seconds

    def _arriving(self, topic: str, key: str, within_s: float, count: int) -> tuple[Evidence, ...]:
        until_s = self._now_s + within_s
        found = [e for e in self.script.evidence if (e.topic, e.key) == (topic, key) and e.id not in self._delivered]
        taken = tuple(sorted((e for e in found if to_s(e.at_ns) <= until_s), key=lambda e: (e.at_ns, e.id))[:count])
        self._delivered.update(e.id for e in taken)
        self._now_s = max(self._now_s, to_s(taken[-1].at_ns)) if taken and len(taken) == count else until_s
        return taken

    def _recalled(self, query: Query) -> tuple[Episode, ...]:
        found = [
            episode
            for episode in self.script.episodes
            if episode.event != query.event
            and (not query.entity or episode.entity == query.entity)
            and (not query.kind or episode.kind == query.kind)
        ]
        near = (lambda e: e.likeness) if query.event else (lambda _: 1.0)
        found.sort(key=lambda e: (-near(e), -e.at_ns, e.event))
        chosen = found[: max(query.limit, 0)]
        return tuple(msgspec.structs.replace(episode, likeness=near(episode)) for episode in chosen)

    def _replied(self, question: Question) -> Reply:
        if self._mode != "delib":
            raise Refusal(f"a process in {self._mode} mode does not deliberate")
        if question.about not in self.script.replies:
            raise Refusal(f"the script has no reply about {question.about!r}")
        return self.script.replies[question.about]

    def _person(self, role: str, within_s: float) -> Reply | None:
        reply = self.script.people.get(role)
        if reply is None:
            self._pass(within_s)
        return reply

    def _child(self, name: str, event: Event) -> Result:
        if name not in self.script.children:
            raise Refusal(f"the script has no treatment {name!r}")
        child = ScriptedMind(self._domain, self._mode, msgspec.structs.replace(self.script, now_s=self._now_s))
        result = child.run(self.script.children[name], event)
        self._now_s = child.now_s
        return result


def _recall(query: Query) -> Request:
    return Request(kind="recall", key="episodes", args=_json(query))


def _called(function: Callable[[], object]) -> object:
    try:
        value = function()
        if isawaitable(value):
            value = asyncio.run(_awaited(value))
    except Exception as error:  # what runs outside may fail in any way; a treatment sees a Refusal
        raise Refusal(repr(error)) from error
    return msgspec.json.decode(msgspec.json.encode(value))


async def _awaited(value: Awaitable[object]) -> object:
    return await value


def _json(value: object) -> bytes:
    return msgspec.json.encode(value)


def _limit(within_s: float) -> float:
    require(
        isinstance(within_s, int | float) and isfinite(within_s) and within_s >= 0.0,
        f"a wait of {within_s!r} s: every wait has a finite limit, 0 or more",
    )
    return float(within_s)


def _named(request: Request) -> str:
    return f"{request.kind} {request.key!r} {request.args.decode()[:200]}"


def _close(treatment: Treatment, thinking: Coroutine[object, object, Result]) -> None:
    try:
        thinking.close()
    except RuntimeError as error:
        raise ContractBroken(f"{treatment.name} did not let itself be evicted: it went on awaiting when it was closed") from error
