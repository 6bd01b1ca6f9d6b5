"""A stand-in for a language model in the experiments: right or wrong at rates that are stated for each kind of event."""

from __future__ import annotations

from collections.abc import Mapping
from hashlib import blake2b

from wakeful.contracts.reasoner import ReasonerError
from wakeful.facts.asking import Question, Reply
from wakeful.facts.values import Fact


class Rate(Fact, frozen=True):
    """How it answers for one kind of event: right with this probability; else ``instead``, or any other option evenly."""

    right: float
    instead: str = ""


class Truth(Fact, frozen=True):
    """What the stand-in, unlike a model, is told of an event: its kind (a key of the rates) and its right treatment."""

    kind: str
    treatment: str


class StandIn:
    """Answers which treatment an event needs, knowing the truth and erring on purpose. It is no model, and has no forecasts.

    Its errors belong to the seed and the event alone: asked again, or in another order, it says the same.

    Args:
        rates: kind of event -> how it answers.
        truths: event id -> what the event is.
        seed: of the errors.
        confidence: what it says of every answer: nothing, it does not know when it errs.

    Raises:
        ValueError: a rate is outside [0, 1], or an event's kind has none.
    """

    name = "stand-in"

    def __init__(
        self,
        rates: Mapping[str, Rate],
        truths: Mapping[str, Truth],
        seed: int = 0,
        confidence: float = 0.9,
        latency_s: float = 0.2,
    ) -> None:
        for kind, rate in rates.items():
            if not 0.0 <= rate.right <= 1.0:
                raise ValueError(f"the stand-in is right on {kind} with {rate.right}; a rate lies between 0 and 1")
        unknown = {truth.kind for truth in truths.values()} - set(rates)
        if unknown:
            raise ValueError(f"the stand-in has no rate for {', '.join(sorted(unknown))}")
        self.latency_s = latency_s
        self._rates, self._truths = dict(rates), truths
        self._seed, self._confidence = seed, confidence

    def describe(self) -> str:
        """That no model answers here, and how often it errs on what.

        >>> StandIn({"pair": Rate(right=1.0), "odd": Rate(right=0.1, instead="diagnosis")}, {}).describe()
        'stand-in, not a model: wrong on 0 % of pair, 90 % of odd (says diagnosis)'
        """
        said = (
            f"{100 * (1 - rate.right):.3g} % of {kind}" + (f" (says {rate.instead})" if rate.instead else "")
            for kind, rate in self._rates.items()
        )
        return "stand-in, not a model: wrong on " + ", ".join(said)

    async def answer(self, question: Question) -> Reply:
        """The right treatment or a wrong one, as the rates say.

        Raises:
            ReasonerError: it was not told of the event, or the right treatment is no option.
        """
        truth = self._truths.get(question.event)
        if truth is None or truth.treatment not in question.options:
            raise ReasonerError(f"the stand-in was told no admissible truth of event {question.event!r}")
        rate = self._rates[truth.kind]
        choice = truth.treatment
        if self._draw("right", question.event) >= rate.right:
            others = [name for name in question.options if name != truth.treatment]
            choice = rate.instead or others[int(self._draw("which", question.event) * len(others))]
        because = ("A stand-in for a model says so: its errors are drawn at stated rates.",)
        return Reply(choice=choice, confidence=self._confidence, because=because, reasoner=self.name)

    def _draw(self, of: str, event: str) -> float:
        key = f"{self._seed}\x1f{of}\x1f{event}".encode()
        return int.from_bytes(blake2b(key, digest_size=8).digest(), "big") / 2**64
