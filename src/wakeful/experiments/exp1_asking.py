"""Who deliberates in Experiment 1: a model, the written guidelines, or a stand-in whose errors are stated."""

from __future__ import annotations

import asyncio
import os
from collections.abc import Mapping, Sequence
from types import TracebackType
from typing import Final, Literal

from wakeful.contracts.reasoner import Reasoner, ReasonerError
from wakeful.deliberation import from_environment, make
from wakeful.experiments.exp1_events import events, spec
from wakeful.experiments.stand_in import Rate, StandIn, Truth
from wakeful.experiments.worlds.service_events import TREATMENTS, World
from wakeful.facts.events import Event
from wakeful.scheduling.thinking import which_treatment
from wakeful.treatments.registry import Registry

ReasonerName = Literal["stand-in", "guidelines", "openai"]

RATES: Final[Mapping[str, Rate]] = {
    "pairs": Rate(right=1.0),
    "the plain unknown object": Rate(right=1.0),
    "the abnormal unknown object": Rate(right=0.1, instead="diagnosis"),
    "random events without context": Rate(right=0.56),
    "random events of task or safety": Rate(right=0.35),
}
"""The stand-in's rates, from the paper's Always-LLM row alone: 97.35 % structured, 44.38 % random, 59.04 % task/safety."""

_AT_ONCE = 8


class Asking:
    """One reasoner for a whole reproduction. Each question is the one that the product's kernel would put.

    Args:
        name: which reasoner; ``openai`` is set up by the environment, its replies are kept in the folder that it names.

    Raises:
        SettingsError: the environment lacks what the reasoner needs.
        ReasonerError: the reasoner's extra is not installed.
    """

    def __init__(self, name: ReasonerName) -> None:
        self.name = name
        settings = from_environment(os.environ)
        meanings = {each: Registry().get(each).says for each in TREATMENTS}
        self._reasoner: Reasoner | None = None if name == "stand-in" else make(name, spec(), settings, meanings)
        self._guidelines = make("guidelines", spec(), settings)
        self._runner = asyncio.Runner()

    def __enter__(self) -> Asking:
        self._runner.__enter__()
        return self

    def __exit__(self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None) -> None:
        self._runner.__exit__(kind, value, trace)

    def describe(self) -> str:
        """One line on who answers, to stand under every table."""
        if self.name == "stand-in":
            return StandIn(RATES, {}).describe()
        return f"the reasoner {self.name}" + (" (offline, by written rules)" if self.name == "guidelines" else "")

    def answers(self, world: World, asked: Sequence[Event]) -> dict[str, str]:
        """The treatment that the reasoner names, by event id; an event that it refused is not there."""
        return self._all(self._reasoner if self._reasoner is not None else _stand_in(world), asked)

    def guidelines(self, asked: Sequence[Event]) -> dict[str, str]:
        """The same from the written guidelines."""
        return self._all(self._guidelines, asked)

    def _all(self, reasoner: Reasoner, asked: Sequence[Event]) -> dict[str, str]:
        return self._runner.run(_ask(reasoner, asked))


async def _ask(reasoner: Reasoner, asked: Sequence[Event]) -> dict[str, str]:
    gate = asyncio.Semaphore(_AT_ONCE)
    found: dict[str, str] = {}

    async def one(event: Event) -> None:
        async with gate:
            try:
                reply = await reasoner.answer(which_treatment(event, (), spec(), TREATMENTS))
            except ReasonerError:
                return
            found[event.id] = reply.choice

    await asyncio.gather(*(one(event) for event in asked))
    return found


def _stand_in(world: World) -> StandIn:
    truths: dict[str, Truth] = {}
    for split in ("calibration", "test"):
        for case, event in zip(getattr(world, split), events(world, split), strict=True):
            kind = {
                "pair": "pairs",
                "plain_unknown": "the plain unknown object",
                "odd_unknown": "the abnormal unknown object",
            }.get(case.part, "random events " + ("of task or safety" if case.task_safety else "without context"))
            truths[event.id] = Truth(kind=kind, treatment=case.truth)
    return StandIn(RATES, truths, seed=world.seed)
