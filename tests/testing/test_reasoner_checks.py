import pytest

from tests.treatments.worlds import DOMAIN
from wakeful.contracts.reasoner import ReasonerError
from wakeful.deliberation.guidelines import GuidelineReasoner
from wakeful.facts.asking import Question, Reply
from wakeful.testing import ContractBroken, check_reasoner

QUESTION = Question(
    about="treatment",
    event="e",
    asks="which treatment?",
    options=("planning", "description"),
    labels=("none", "stop"),
    facts={"state": "blocked"},
)


class Answering:
    """Answers with what it was made with, or raises it."""

    name = "answering"
    latency_s = 0.0

    def __init__(self, *replies: Reply | Exception) -> None:
        self._replies = replies
        self._asked = 0

    async def answer(self, question: Question) -> Reply:
        reply = self._replies[self._asked % len(self._replies)]
        self._asked += 1
        if isinstance(reply, Exception):
            raise reply
        if "system:" in question.facts.get("says", "") and reply.choice == "obey":
            return Reply(choice="shutdown", confidence=1.0)
        return reply


GOOD = Reply(choice="planning", confidence=0.7, forecast="stop", forecast_probability=0.6)


def test_the_guidelines_keep_the_contract() -> None:
    [reply] = check_reasoner(GuidelineReasoner(DOMAIN), [QUESTION])
    assert reply.choice == "planning"


def test_a_refusal_is_within_the_contract_and_gives_no_reply() -> None:
    assert check_reasoner(Answering(ReasonerError("over budget")), [QUESTION]) == []


def test_a_model_need_not_repeat_itself() -> None:
    other = Reply(choice="description", confidence=0.5)
    assert len(check_reasoner(Answering(GOOD, other), [QUESTION], repeatable=False)) == 1
    with pytest.raises(ContractBroken, match="two answers"):
        check_reasoner(Answering(GOOD, other), [QUESTION])


@pytest.mark.parametrize(
    ("reply", "why"),
    [
        (Reply(choice="dance", confidence=0.7), "no option"),
        (Reply(choice="planning", confidence=1.7), "confidence"),
        (Reply(choice="planning", confidence=float("nan")), "confidence"),
        (Reply(choice="planning", confidence=0.7, forecast="rain"), "no label"),
        (Reply(choice="planning", confidence=0.7, forecast="stop", forecast_probability=-1.0), "forecast probability"),
        (Reply(choice="planning", confidence=0.7, cost_usd=-1.0), "cost"),
        (ValueError("model said nothing"), "not ReasonerError"),
        (ReasonerError(""), "must say what went wrong"),
        (Reply(choice="obey", confidence=0.7), "no option"),
    ],
)
def test_an_inadmissible_answer_is_caught(reply: Reply | Exception, why: str) -> None:
    with pytest.raises(ContractBroken, match=why):
        check_reasoner(Answering(reply), [QUESTION])


def test_an_answer_that_obeys_the_world_is_caught() -> None:
    question = Question(about="a", event="e", asks="?", options=("obey", "planning"))
    with pytest.raises(ContractBroken, match="'shutdown', which is no option"):
        check_reasoner(Answering(Reply(choice="obey", confidence=1.0)), [question])
