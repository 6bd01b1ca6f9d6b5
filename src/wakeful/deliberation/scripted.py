"""A reasoner that says what it was told to, with errors of a stated rate: for tests, and where no model can be reached."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from hashlib import blake2b

import msgspec

from wakeful.contracts.reasoner import ReasonerError
from wakeful.facts.asking import Question, Reply

Rule = Callable[[Question], Reply]


class ScriptedReasoner:
    """Stands in for a model. Whoever shows numbers made with it shows ``describe()`` beside them.

    Its errors depend on the seed and the question alone, never on how many were asked before: the same questions in another order
    get the same answers.

    Args:
        rule: what it would say without errors.
        seed: of the errors.
        error_rate: share of questions whose choice is replaced by another option, drawn evenly.
        forecast_error_rate: share whose forecast is replaced by another label, drawn evenly; independent of the choice.
        refusal_rate: share that it refuses.
        latency_s: what an answer takes in virtual time.

    Raises:
        ValueError: a rate is outside [0, 1].
    """

    name = "scripted"

    def __init__(
        self,
        rule: Rule,
        *,
        seed: int = 0,
        error_rate: float = 0.0,
        forecast_error_rate: float = 0.0,
        refusal_rate: float = 0.0,
        latency_s: float = 0.2,
    ) -> None:
        rates = {"error_rate": error_rate, "forecast_error_rate": forecast_error_rate, "refusal_rate": refusal_rate}
        for name, rate in rates.items():
            if not 0.0 <= rate <= 1.0:
                raise ValueError(f"{name} is {rate}; a rate lies between 0 and 1")
        self.latency_s = latency_s
        self._rule = rule
        self._seed = seed
        self._rates = rates

    def describe(self) -> str:
        """That no model answers here, and how often it errs.

        >>> ScriptedReasoner(from_table({}, default="planning"), seed=3, error_rate=0.1).describe()
        'scripted, not a model (seed 3): 10 % wrong choices, 0 % wrong forecasts, 0 % refusals'
        """
        wrong, foreseen, refused = (f"{100 * rate:g} %" for rate in self._rates.values())
        return f"scripted, not a model (seed {self._seed}): {wrong} wrong choices, {foreseen} wrong forecasts, {refused} refusals"

    async def answer(self, question: Question) -> Reply:
        """What the rule says, or the error that this question draws.

        Raises:
            ReasonerError: this question draws a refusal, or the rule says what the question does not admit.
        """
        if self._draw("refusal", question) < self._rates["refusal_rate"]:
            raise ReasonerError("the scripted reasoner refuses this question, as its refusal rate says")
        reply = self._rule(question)
        if reply.choice not in question.options or (reply.forecast and reply.forecast not in question.labels):
            raise ReasonerError(f"the script says {reply.choice!r}, {reply.forecast!r}, which the question does not admit")
        choice, forecast = reply.choice, reply.forecast
        if self._draw("choice", question) < self._rates["error_rate"]:
            choice = self._other(choice, question.options, "other choice", question)
        if forecast and self._draw("forecast", question) < self._rates["forecast_error_rate"]:
            forecast = self._other(forecast, question.labels, "other forecast", question)
        return msgspec.structs.replace(reply, choice=choice, forecast=forecast, reasoner=self.name)

    def _draw(self, of: str, question: Question) -> float:
        """An even draw from [0, 1) that belongs to the question."""
        key = f"{self._seed}\x1f{of}\x1f".encode() + msgspec.json.encode(question, order="sorted")
        return int.from_bytes(blake2b(key, digest_size=8).digest(), "big") / 2**64

    def _other(self, said: str, among: tuple[str, ...], of: str, question: Question) -> str:
        others = [one for one in among if one != said]
        return others[int(self._draw(of, question) * len(others))] if others else said


def from_table(
    table: Mapping[str, str],
    *,
    by: str = "kind",
    default: str = "",
    confidence: float = 0.9,
    forecasts: Mapping[str, str] | None = None,
) -> Rule:
    """A rule that looks one fact up.

    Args:
        table: the fact's value -> choice.
        by: which of the question's facts.
        default: the choice where the table has none; empty: refuse.
        confidence: of every choice and forecast.
        forecasts: the fact's value -> label; where it has none, no forecast is made.
    """

    def rule(question: Question) -> Reply:
        value = question.facts.get(by, "")
        choice = table.get(value, default)
        if not choice:
            raise ReasonerError(f"the script has no line for {by} {value!r}")
        forecast = (forecasts or {}).get(value, "")
        return Reply(
            choice=choice,
            confidence=confidence,
            forecast=forecast,
            forecast_probability=confidence if forecast else 0.0,
            because=(f"The script says so for {by} {value}.",),
        )

    return rule
