"""Through the whole kernel: a reasoner that lies to each treatment's own question changes nothing of what it concludes.

The reasoner is scripted: it chooses the treatment honestly, and then answers the treatment's typed question with what fits the
question's schema and is false by the domain, all the way through a simulated shift.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import islice

import msgspec
import pytest

from wakeful.contracts.bridge import Item
from wakeful.contracts.detector import DetectorFactory
from wakeful.contracts.domain import Domain
from wakeful.contracts.reasoner import ReasonerError
from wakeful.domains import load
from wakeful.drivers.assembly import assemble
from wakeful.drivers.simulated import SimulatedDriver
from wakeful.facts.asking import Question, Reply
from wakeful.facts.domain import Cause, DomainSpec, Guideline
from wakeful.facts.events import Observation
from wakeful.facts.lines import Concluded
from wakeful.facts.settings import MindSettings
from wakeful.facts.values import Raw
from wakeful.journal import MemoryJournal
from wakeful.journal.audit import audit
from wakeful.journal.results import result_fields
from wakeful.treatments.consulting import ANSWERED, NO_ANSWER

OBSERVATIONS = 1_200
HONEST_S = 0.2

#: What is said to each treatment: it fits the schema that went with the question, and the domain knows nothing of it.
LIES: Mapping[str, Mapping[str, object]] = {
    "description": {"attributes": ["halo", "aura"]},
    "memory": {"case": "event 0 of another world"},
    "risk_prediction": {"hazard": "meteorite", "likelihood": 1.0},
    "planning": {"nodes": ["hall", "moon", "reception"]},
    "diagnosis": {"fault": "gremlins"},
    "analogy": {"case": "nothing of the sort"},
    "comparison": {"attribute": "halo"},
    "causal_analysis": {"event": "tomorrow's"},
}


class Only:
    """The service robot's domain in which nothing but one treatment may be chosen, and things may bring one another about."""

    def __init__(self, domain: Domain, treatment: str) -> None:
        self._domain = domain
        self.spec: DomainSpec = msgspec.structs.replace(
            domain.spec,
            treatments=(treatment,),
            guideline=(Guideline(treat=treatment, because="nothing else may be chosen"),),
            cause=(Cause(cause="object", effect="object", within_s=600.0, because="one thing upsets another"),),
        )

    def detectors(self) -> Mapping[str, DetectorFactory]:
        return self._domain.detectors()

    def simulate(self, seed: int) -> Iterator[Observation] | None:
        return self._domain.simulate(seed)


class Liar:
    """Chooses the only treatment, and then lies, or says that it has no answer."""

    name = "liar"
    latency_s = HONEST_S

    def __init__(self, treatment: str, lies: bool) -> None:
        self._treatment, self._lies = treatment, lies
        self.lied = 0

    async def answer(self, question: Question) -> Reply:
        if question.options != (ANSWERED, NO_ANSWER):
            return Reply(choice=self._treatment, confidence=0.9, reasoner=self.name)
        if question.about != self._treatment:
            raise ReasonerError("a child's question is none of this test's")
        self.lied += 1
        answer = Raw(msgspec.json.encode(LIES[self._treatment]))
        choice = ANSWERED if self._lies else NO_ANSWER
        return Reply(choice=choice, confidence=1.0, because=("believe me",), answer=answer, reasoner=self.name)


def shift(treatment: str, lies: bool) -> tuple[dict[str, dict[str, object]], int]:
    """What was concluded of each event, and how often the reasoner was put a treatment's own question."""
    domain = Only(load("service_robot"), treatment)
    kernel, learner = assemble(domain, MindSettings(consult=True, trains=False))
    journal, liar = MemoryJournal(), Liar(treatment, lies)
    driver = SimulatedDriver(kernel, journal, liar, learner)

    def items(after: int) -> Iterator[Item]:
        return islice(domain.simulate(0) or iter(()), after + 1, OBSERVATIONS)

    for _ in driver.run("shift", "seed 0", items):
        pass
    driver.close()
    assert audit(journal).ok
    concluded = [line.record for line in journal.lines() if isinstance(line.record, Concluded)]
    return {each.event: result_fields(each.result) for each in concluded if each.treatment == treatment}, liar.lied


def own(result: Mapping[str, object]) -> dict[str, object]:
    """The result but for what it says of the consultation."""
    rests_on = result.get("rests_on")
    kept = [each for each in rests_on if not str(each).startswith("reasoner's")] if isinstance(rests_on, list) else rests_on
    return {**{name: value for name, value in result.items() if name != "consulted"}, "rests_on": kept}


@pytest.mark.parametrize("treatment", LIES)
def test_lies_are_refused_and_named_and_the_treatment_concludes_what_it_would_have(treatment: str) -> None:
    lied_to, lies = shift(treatment, lies=True)
    unanswered, _ = shift(treatment, lies=False)
    assert lies > 0
    assert len(lied_to) > 5
    consulted = [result["consulted"] for result in lied_to.values() if result.get("consulted")]
    assert consulted
    for each in consulted:
        assert isinstance(each, dict)
        assert each.get("used", False) is False
        assert str(each["why"]).startswith("refused: ")
    assert {event: own(result) for event, result in lied_to.items()} == {
        event: own(result) for event, result in unanswered.items()
    }
