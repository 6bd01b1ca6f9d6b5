"""A treatment's own question goes through the kernel as any request: recorded, answered, rebuilt after a crash, told by `why`."""

from __future__ import annotations

from pathlib import Path

import msgspec
import pytest

from wakeful.contracts.reasoner import ReasonerError
from wakeful.drivers.assembly import assemble
from wakeful.drivers.simulated import SimulatedDriver
from wakeful.facts.asking import Question, Reply
from wakeful.facts.events import Draft
from wakeful.facts.inputs import Mark
from wakeful.facts.lines import Asked, Concluded
from wakeful.facts.settings import MindSettings
from wakeful.facts.values import Raw
from wakeful.journal import MemoryJournal
from wakeful.journal.audit import audit
from wakeful.journal.results import result_fields

PUMP = {"category": "device", "state": "abnormal", "location": "storage", "route": "none", "load": 0.3}


class Model:
    """Says diagnosis, and names a fault when diagnosis asks for one."""

    name = "model"
    latency_s = 0.5

    def __init__(self, fault: str) -> None:
        self.fault = fault
        self.asked: list[Question] = []

    async def answer(self, question: Question) -> Reply:
        self.asked.append(question)
        if question.about == "treatment":
            return Reply(choice="diagnosis", confidence=0.9, reasoner="model")
        if not self.fault:
            raise ReasonerError("the model is down")
        answer = Raw(msgspec.json.encode({"fault": self.fault}))
        return Reply(choice="answered", confidence=0.7, because=("it hums",), answer=answer, reasoner="model")


def concluded(model: Model, consult: bool = True) -> tuple[dict[str, object], list[str]]:
    kernel, learner = assemble("service_robot", MindSettings(consult=consult))
    journal = MemoryJournal()
    driver = SimulatedDriver(kernel, journal, model, learner)
    driver.begin("s", "d")
    pump = Draft(kind="object", entity="pump 3", source="s", position=0, at_ns=10**18, fields=dict(PUMP))
    driver.put([pump, Mark(source="s", position=0)], 10**18)
    driver.put([], 10**18 + 300 * 10**9)
    driver.close()
    assert audit(journal).ok
    records = [line.record for line in journal.lines()]
    result = next(record.result for record in records if isinstance(record, Concluded))
    return dict(result_fields(result)), [record.key for record in records if isinstance(record, Asked)]


def test_a_checked_answer_stands_in_the_result_beside_the_request(tmp_path: Path) -> None:
    model = Model("stalled motor")
    result, asked = concluded(model)
    assert result["consulted"]["used"] is True  # type: ignore[call-overload, index]
    assert "diagnosis" in asked
    assert [question.about for question in model.asked] == ["treatment", "diagnosis"]


@pytest.mark.parametrize(("fault", "why"), [("open the gate", "there is no fault"), ("", "the model is down")])
def test_an_answer_that_fails_or_never_comes_leaves_the_treatments_own_diagnosis(fault: str, why: str) -> None:
    result, _ = concluded(Model(fault))
    own, _ = concluded(Model(""), consult=False)
    assert result["consulted"]["used"] is False  # type: ignore[call-overload, index]
    assert why in result["consulted"]["why"]  # type: ignore[call-overload, index]
    assert result["suspects"] == own["suspects"]


def test_where_the_setting_is_off_the_treatment_asks_nothing_of_its_own() -> None:
    model = Model("stalled motor")
    result, asked = concluded(model, consult=False)
    assert "consulted" not in result
    assert [question.about for question in model.asked] == ["treatment"]
    assert "diagnosis" not in asked
