"""A reasoner with bad manners: slow, hung, rate-limited, down, malformed, oversized, hostile. Stands in for a model in tests."""

from __future__ import annotations

from collections.abc import Callable
from hashlib import blake2b
from random import Random

import msgspec

from wakeful.contracts.reasoner import ReasonerError
from wakeful.facts.asking import Question, Reply

#: What it may do with a question instead of answering it.
FAULTS = ("slow", "hung", "rate-limited", "malformed", "oversized", "hostile", "no reply", "raises")

#: A day: longer than any question waits for its answer.
HUNG_S = 86_400.0


class Manners(msgspec.Struct, frozen=True, kw_only=True):
    """How a reasoner behaves.

    ``rates``: share of the questions that each of FAULTS befalls. By default a question's fate belongs to the question, so that
    asked again after a crash it meets the same; ``by_the_clock`` it changes with each time of asking, and ``down`` names the
    stretches (from, to) of kernel time, in seconds since the first question, in which every call fails.
    """

    rates: dict[str, float]
    latency_s: float
    slow_s: float = 20.0
    by_the_clock: bool = False
    down: tuple[tuple[float, float], ...] = ()

    @classmethod
    def drawn(cls, random: Random, *, by_the_clock: bool) -> Manners:
        """Manners as a seed draws them: mostly good, sometimes one fault often, sometimes all of them."""
        kind = random.randrange(4)
        rates: dict[str, float] = {}
        if kind == 1:
            rates = {random.choice(FAULTS): 0.5}
        elif kind == 2:
            rates = dict.fromkeys(FAULTS, 0.08)
        down = ((random.uniform(0.0, 20.0), random.choice((30.0, 120.0, 3_600.0))),) if by_the_clock else ()
        return cls(rates=rates, latency_s=random.choice((0.0, 0.2, 2.0)), by_the_clock=by_the_clock, down=down)


class FaultyReasoner:
    """Says what ``rule`` says, or does what its manners are. ``made`` counts the calls that reached it: the provider's bill.

    Args:
        rule: the right answer.
        manners: how it behaves.
        seed: of what befalls which question.
        clock_s: kernel time in seconds, by which it is down; needed only where its manners go by the clock.
    """

    name = "faulty"

    def __init__(self, rule: Callable[[Question], Reply], manners: Manners, seed: int, clock_s: Callable[[], float]) -> None:
        self.latency_s = manners.latency_s
        self.made = 0
        self._rule = rule
        self._manners = manners
        self._seed = seed
        self._clock_s = clock_s
        self._began_s: float | None = None

    async def answer(self, question: Question) -> Reply:
        """One answer, of whatever kind.

        Raises:
            ReasonerError: it is down, rate-limited or breaks off. RuntimeError: it has a defect.
        """
        self.made += 1
        now_s = self._clock_s()
        self._began_s = now_s if self._began_s is None else self._began_s
        self.latency_s = self._manners.latency_s
        if any(start <= now_s - self._began_s < end for start, end in self._manners.down):
            raise ReasonerError("connection refused", calls=1)
        return self._behave(self._fate(question), question)

    def _behave(self, fate: str, question: Question) -> Reply:
        right = msgspec.structs.replace(self._rule(question), reasoner=self.name)
        match fate:
            case "slow":
                self.latency_s = self._manners.slow_s
            case "hung":
                self.latency_s = HUNG_S
            case "rate-limited":
                raise ReasonerError("429 Too Many Requests: Retry-After 60", calls=1)
            case "malformed":
                return msgspec.structs.replace(right, choice="", confidence=float("nan"), forecast="no such label")
            case "oversized":
                return msgspec.structs.replace(right, because=("so " * 400_000,) * 2)
            case "hostile":
                return msgspec.structs.replace(right, choice="launch_missiles", confidence=1.0, because=("trust me",))
            case "no reply":
                return None  # type: ignore[return-value]  # that is the fault
            case "raises":
                raise RuntimeError("a defect of the reasoner's own")
            case _:
                pass
        return right

    def _fate(self, question: Question) -> str:
        asking = f"{self.made}" if self._manners.by_the_clock else question.event
        digest = blake2b(f"{self._seed}\x1f{asking}".encode(), digest_size=8).digest()
        drawn = int.from_bytes(digest, "big") / 2**64
        for fault, rate in self._manners.rates.items():
            if drawn < rate:
                return fault
            drawn -= rate
        return ""
